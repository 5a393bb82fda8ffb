"""Eyeshadow: up to four layers on each eye, each in a place of its own around it."""

from typing import TYPE_CHECKING

from makeup_video.pipeline.look.kinds.density_map import density_at
from makeup_video.pipeline.look.kinds.fields import LID, EyePlaces
from makeup_video.pipeline.look.kinds.kind import (
    BOTH_EYES,
    LEFT_EYE,
    RIGHT_EYE,
    Coat,
    Dial,
    Kind,
    Shape,
)
from makeup_video.pipeline.look.kinds.ramps import fall, rise, smooth
from makeup_video.pipeline.look.params import GraphicsParams

if TYPE_CHECKING:
    import numpy as np

# Rows in the order of SETTINGS.
_FINISHES = {
    "matte":    (0.92, 0.00, 0.95, 0.00, 0.60, 0.75, 0.05, 0.20, 0.20, 0.90, 0.00, 0.50, 0.50, 1.0),
    "satin":    (0.85, 0.20, 0.80, 0.00, 0.60, 0.80, 0.05, 0.40, 0.40, 0.80, 0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.28, 0.10, 0.80, 0.00, 0.80, 0.90, 0.08, 0.40, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.60, 0.90, 0.40, 0.10, 0.60, 0.80, 0.08, 0.40, 0.60, 0.50, 0.00, 0.50, 0.50, 1.0),
    "metallic": (0.90, 2.50, 0.62, 0.15, 0.60, 0.70, 0.05, 0.00, 0.60, 0.60, 0.60, 0.10, 1.00, 1.0),
    "shimmer":  (0.85, 1.60, 0.50, 0.05, 0.70, 0.75, 0.08, 0.10, 0.50, 0.60, 0.70, 0.30, 0.70, 1.0),
}  # fmt: skip

_NUMBERS = ("low", "high", "inner", "outer", "lift", "softness")
_ROWS = {
    "lid": (0.0, 0.93, 0.11, 1.03, 0.0, 0.50),
    "crease": (0.64, 1.38, 0.16, 1.12, 0.2, 0.50),
    "brow_bone": (1.36, 1.86, 0.38, 1.20, 0.2, 0.48),
    "outer": (0.0, 1.20, 0.66, 1.13, 0.3, 0.60),
    "under": (-0.70, 0.0, 0.12, 1.14, 0.0, 0.50),
    "inner": (-1.30, 0.85, -0.05, 0.17, 0.0, 0.50),
    "full": (0.0, 1.62, 0.12, 1.13, 0.2, 0.70),
}
_SLOTS = {name: dict(zip(_NUMBERS, row, strict=True)) for name, row in _ROWS.items()}
_LID = _SLOTS["lid"]
_SHARP, _FADE = 0.02, 2.0  # heights over which the lower border fades: at the corner, and beyond
# The upper border comes down over so many widths of the eye before each end, by this share of its
# height above that of the zone `lid` (0.93).
_ROUND = 0.45, 0.55
# A wing's upper border rises from this `across` on, by this share of the wing's lift.
_SWEEP, _TAPER = 0.62, 0.55
# How the outer end leans above the lash line: how far inwards for a height of 1, in widths of the
# eye; how much softer it becomes for a height of 1; and up to which height it leans.
_LEANS, _SPREADS, _LEANS_TO = 0.14, 0.8, 1.5
_SLIM = 0.45  # depth under the inner corner, as a share of that under the outer one
# Over what share of a layer's width the lower border rises to its outer end, as an ellipse, and how
# far beyond that end it would meet the lash line, in widths of the eye.
_ROUNDED, _BEYOND = 0.85, 0.1


def _coats(at: EyePlaces, product: GraphicsParams, shape: Shape) -> list[Coat]:
    """One coat, with soft borders that product and shape widen together.

    Beyond the corners of the eye no lash line separates the skin above it from the skin below. All
    borders go on there from one side to the other.
    """
    import numpy as np

    if shape["map"]:
        return [Coat(product, density_at(at, shape["map"]))]
    low, high = shape["low"], shape["high"]
    if not (low < 0 or (at.is_upper and high > 0)):
        return []
    wide = 2 * shape["softness"] * (0.5 + product.edge_softness)
    density = rise(at.across, shape["inner"], 0.38 * wide)
    density = density * _outer_end(at, shape, 0.30 * wide)
    if high:  # at 0 the lash line is the border
        own = at.height if at.is_upper or high < 0 else np.float32(0)
        top = own + _rounded(at, shape) - _lifted(at, shape)
        density = density * fall(top, high, 0.95 * wide * _room(shape))
    height = at.height - np.float32(shape["lift"] / LID) * np.maximum(at.across - 1, 0)
    if low > 0:
        density = density * rise(height, low, 0.90 * wide * _room(shape))
    elif low < 0:
        slim = 1 / _depth(at, shape)
        # full strength at the lash line, however close the border is
        density = density * rise(height * slim, low, min(0.90 * wide, -2 * low))
    if at.is_upper and low == 0:
        density = density * _lash_line(at, height, wide)
    if at.is_upper and high <= 0:
        density = density * (1 - _lash_line(at, 0.5 * height, wide))
    return [Coat(product, density)]


def _outer_end(at: EyePlaces, shape: Shape, wide: float) -> "np.ndarray":
    """The outer end. Higher above the lash line it is softer and lies further in: otherwise it
    would be upright. It leans less the more a wing rises beyond it."""
    import numpy as np

    if not at.is_upper:
        return fall(at.across, shape["outer"], wide)
    up = np.minimum(at.height, _LEANS_TO) * np.float32(1 - min(max(shape["lift"], 0), 1))
    spread = 1 + _SPREADS * up
    ended: np.ndarray = fall((at.across - shape["outer"] + _LEANS * up) / spread, 0.0, wide)
    return ended


def _depth(at: EyePlaces, shape: Shape) -> "np.ndarray":
    """How far below the eye the lower border lies at a place, as a share of `low`."""
    import numpy as np

    wide = _ROUNDED * max(shape["outer"] - shape["inner"], 0.0) + _BEYOND
    past = 1 - (shape["outer"] + _BEYOND - at.across) * np.float32(1 / wide)
    round_end: np.ndarray = np.sqrt(1 - np.clip(past, 0, 0.98) ** 2)
    if not at.is_upper:
        round_end *= _SLIM + (1 - _SLIM) * np.clip(at.across, 0, 1)
    return round_end


def _lash_line(at: EyePlaces, height: "np.ndarray", wide: float) -> "np.ndarray":
    """The end of a colour at the lash line: 0 below the line, 1 above it. Beyond the corners, where
    there is no lash line, the end is softer the further out it is."""
    import numpy as np

    beyond = np.maximum(np.maximum(at.across - 1, -at.across), 0)
    ended: np.ndarray = smooth((height + np.float32(_SHARP)) / (_SHARP + _FADE * wide * beyond))
    return ended


def _rounded(at: EyePlaces, shape: Shape) -> "np.ndarray":
    """How much lower the upper border is at a place, in heights: the border arches over the eye."""
    import numpy as np

    reach, deep = _ROUND
    inside = np.minimum(at.across - shape["inner"], shape["outer"] - at.across)
    bent = np.clip(1 - inside * np.float32(1 / reach), 0, 1.5)
    arch: np.ndarray = bent * bent * np.float32(deep * max(shape["high"] - 0.93, 0))
    return arch


def _lifted(at: EyePlaces, shape: Shape) -> "np.ndarray":
    """How far a wing lifts the upper border, in heights: from _SWEEP on, with no kink."""
    import numpy as np

    out = np.maximum(at.across - np.float32(_SWEEP), 0)
    lifted: np.ndarray = (
        out * out * (np.float32(_TAPER * shape["lift"] / LID) / (out + (1 - _SWEEP)))
    )
    return lifted


def _room(shape: Shape) -> float:
    """The factor of a band's borders: a narrow band needs narrower borders, otherwise nothing of it
    would be at full strength."""
    high: float = shape["high"]
    low: float = shape["low"]
    return min(1.0, 0.5 + high - max(low, 0.0))


KIND = Kind(
    name="eyeshadow",
    part="eyes",
    title="Eyes",
    product="Eyeshadow",
    words=("eye", "shadow", "shadows", "eye shadow", "lid", "lids", "eyelid", "eyelids"),
    must_see="eyes",
    category=r"(?<![a-z])eye(?![ _-]?(brow|lash|lin))",
    first_rgb=(90, 58, 46),
    finishes=_FINISHES,
    is_read=True,
    follows_color=True,
    remark="a powder, so softer borders and broader highlights",
    dials=(
        Dial("slot", "lid", "Zone", "The zone in which it lies.", choices=tuple(_SLOTS)),
        Dial("eye", BOTH_EYES, "Eye", "Which of the wearer's eyes wear it.",
             choices=(BOTH_EYES, LEFT_EYE, RIGHT_EYE)),
        Dial("low", _LID["low"], "From", "Its lower border: 0 the lash line, 1 the crease, "
             "2 the brow; below 0 under the eye.", low=-1.3, high=2),
        Dial("high", _LID["high"], "To", "Its upper border, in the same heights.",
             low=-1.3, high=2.2),
        Dial("inner", _LID["inner"], "Inner", "Its inner border: 0 the inner corner, 1 the outer.",
             low=-0.3, high=1.6),
        Dial("outer", _LID["outer"], "Outer", "Its outer border, a wing beyond 1.",
             low=-0.3, high=1.6),
        Dial("lift", _LID["lift"], "Lift", "How steeply the wing rises: its slope.",
             low=-0.5, high=1.5),
        Dial("softness", _LID["softness"], "Softness", "How far its borders fade."),
        Dial("map", "", "Map", "How densely it lies at each place around the eye, as a photo shows "
             "it; the other numbers then change nothing.", is_map=True),
    ),
    slot_words={
        "lid": ("lids", "eyelid"),
        "crease": ("socket", "fold"),
        "brow_bone": ("brow", "under brow", "below brow"),
        "outer": ("outside", "outer corner", "outer v"),
        "under": ("below", "lower", "lower lid", "under eye", "lower lash line"),
        "inner": ("inside", "inner corner", "tear duct"),
        "full": ("all", "whole", "everywhere"),
    },
    slots=_SLOTS,
    most=4,
    order=20,
    shown={"outer": 1.3},
    region="eyes",
    coats=_coats,
    spared=0.1,
    keep_highlights=0.15,
)  # fmt: skip
