"""An eyeliner from the numbers that a net reads: a line is too thin to be measured cell by cell."""

from dataclasses import replace

from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.makeup_numbers import ReadLayer
from makeup_video.pipeline.reference.product_film import likely_share
from makeup_video.pipeline.reference.read_liner import LinerForm

_LEAST_OPAQUE = 0.85  # a thin line in a small photo looks sheerer than it is
# The probability from which all of that is painted, and what share of it is painted of a line that
# is hardly likely: beside a heavy line thin ones, or mere lashes, are read as less likely.
_ALL_FROM, _UNLIKELY_SHARE = 0.8, 0.5


def liner(read: ReadLayer, form: LinerForm, lower: float = 0.0, probability: float = 1.0) -> Layer:
    """The layer of a liner that is worn.

    read: its colour and opacity.  lower: the dial of the lower line, 0 for none.  probability: that
    the liner is worn; the less likely, the sheerer.
    """
    kind = KINDS["eyeliner"]
    shape = {"thickness": form.thickness}
    if lower:
        shape["lower"] = lower
    if form.wing is not None:
        shape |= {"wing": form.wing.length, "wing_angle": form.wing.angle}
    worn = product([round(code, 3) for code in read.rgb], kind.first_finish, kind.part)
    share = likely_share(probability, _ALL_FROM, _UNLIKELY_SHARE)
    opacity = round(share * max(read.opacity, _LEAST_OPAQUE), 3)
    return Layer(kind.name, replace(worn, opacity=opacity), shape)
