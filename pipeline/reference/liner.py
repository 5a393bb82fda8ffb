"""An eyeliner from the numbers that a net reads: a line is too thin to be measured cell by cell."""

from dataclasses import replace

from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.makeup_numbers import ReadLayer
from makeup_video.pipeline.reference.wing import Wing

_LEAST_OPAQUE = 0.85  # a thin line in a small photo looks sheerer than it is
_LEAST_LOWER = 0.32  # less is none: a net that is not sure returns a little


def liner(read: ReadLayer, wing: Wing | None) -> Layer:
    """The layer of a liner that is worn.  wing: None for none."""
    kind = KINDS["eyeliner"]
    shape = {"thickness": read.shape["thickness"]}
    if read.shape["lower"] >= _LEAST_LOWER:
        shape["lower"] = read.shape["lower"]
    if wing is not None:
        shape |= {"wing": wing.length, "wing_angle": wing.angle}
    worn = product(read.rgb, kind.first_finish, kind.part)
    return Layer(kind.name, replace(worn, opacity=max(read.opacity, _LEAST_OPAQUE)), shape)
