"""The portrait as a reference photo, and readings of photos that are made up."""

from functools import cache

from makeup_video.pipeline import find_faces
from makeup_video.pipeline.reference.estimate import Estimate
from makeup_video.pipeline.reference.read_makeup import WORN_FROM
from people import portrait


@cache
def face():
    return find_faces(portrait())[0]


def certain(look):
    """The estimate of a photo that surely shows this look."""
    return Estimate(look, {kind: 0.97 if look.of(kind) else 0.1 for kind in WORN_FROM})
