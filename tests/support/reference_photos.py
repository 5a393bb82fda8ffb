"""The portrait as a reference photo."""

from functools import cache

from makeup_video.pipeline import find_faces
from people import portrait


@cache
def face():
    return find_faces(portrait())[0]
