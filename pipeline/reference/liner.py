"""An eyeliner from the numbers that a net reads: a line is too thin to be measured cell by cell."""

from dataclasses import replace

from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.makeup_numbers import ReadLayer

_LEAST_OPAQUE = 0.85  # a thin line in a small photo looks sheerer than it is
# Less than that is none: a net that is not sure returns a little of both.
_LEAST_WING, _LEAST_LOWER = 0.13, 0.32


def liner(read: ReadLayer) -> Layer:
    """The layer of a liner that is worn."""
    kind, shape = KINDS["eyeliner"], dict(read.shape)
    for name, least in (("wing", _LEAST_WING), ("lower", _LEAST_LOWER)):
        shape[name] = shape[name] if shape[name] >= least else 0.0
    worn = product(read.rgb, kind.first_finish, kind.part)
    return Layer(kind.name, replace(worn, opacity=max(read.opacity, _LEAST_OPAQUE)), shape)
