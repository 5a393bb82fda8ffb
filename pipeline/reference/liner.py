"""Makes an eyeliner from numbers that nets read: a line is too thin to measure cell by cell."""

from dataclasses import replace

from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.makeup_numbers import ReadLayer
from makeup_video.pipeline.reference.product_film import likely_share
from makeup_video.pipeline.reference.read_liner import LinerForm

_LEAST_OPAQUE = 0.85  # a thin line in a small photo looks sheerer than it is
# From the first probability on, a line has all of its opacity; a hardly likely line has the second
# share of it. A thin line, or mere lashes, are read as less likely than a heavy line.
_ALL_FROM, _UNLIKELY_SHARE = 0.8, 0.5


def liner(read: ReadLayer, form: LinerForm, lower: float = 0.0, probability: float = 1.0) -> Layer:
    """The layer of an eyeliner that is worn.

    read: the liner's colour and opacity.  form: its thickness and its wing.
    lower: the dial of the lower line, 0 for none.
    probability: that the liner is worn; the less likely, the sheerer it is painted.
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
