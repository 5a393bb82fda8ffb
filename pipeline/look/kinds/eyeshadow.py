"""Eye-shadow: up to four layers, each in a place of its own around the eye."""

from makeup_video.pipeline.look.kinds.fields import LID, EyeFields
from makeup_video.pipeline.look.kinds.kind import Coat, Dial, Kind, Shape
from makeup_video.pipeline.look.kinds.ramps import fall, rise, smooth
from makeup_video.pipeline.look.params import GraphicsParams

# Rows in the order of SETTINGS.
_FINISHES = {
    "matte":    (0.92, 0.00, 0.95, 0.00, 0.60, 0.75, 0.05, 0.20, 0.20, 0.90, 0.00, 0.50, 0.50, 1.0),
    "satin":    (0.85, 0.20, 0.80, 0.00, 0.60, 0.80, 0.05, 0.40, 0.40, 0.80, 0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.28, 0.10, 0.80, 0.00, 0.80, 0.90, 0.08, 0.40, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.60, 0.90, 0.40, 0.10, 0.60, 0.80, 0.08, 0.40, 0.60, 0.50, 0.00, 0.50, 0.50, 1.0),
    "metallic": (0.90, 0.70, 0.60, 0.15, 0.60, 0.70, 0.05, 0.20, 0.60, 0.60, 0.60, 0.10, 1.00, 1.0),
    "shimmer":  (0.85, 0.40, 0.65, 0.05, 0.70, 0.75, 0.08, 0.30, 0.50, 0.60, 0.70, 0.30, 0.70, 1.0),
}  # fmt: skip

# low, high, inner, outer, lift, softness
_SLOTS = {
    "lid": (0.0, 0.93, 0.11, 1.03, 0.0, 0.50),
    "crease": (0.62, 1.40, 0.19, 1.09, 0.2, 0.36),
    "brow_bone": (1.35, 2.00, 0.40, 1.10, 0.2, 0.30),
    "outer": (0.0, 1.30, 0.60, 1.15, 0.3, 0.60),
    "under": (-0.75, 0.0, 0.10, 1.06, 0.0, 0.40),
    "inner": (-0.70, 0.70, -0.14, 0.20, 0.0, 0.30),
    "full": (0.0, 1.70, 0.10, 1.15, 0.2, 0.80),
}
_SHARP, _FADE = 0.02, 4.0  # heights over which the lower border fades: at the corner, and beyond
_NUMBERS = ("low", "high", "inner", "outer", "lift", "softness")


def _coats(at: EyeFields, product: GraphicsParams, shape: Shape) -> list[Coat]:
    """One coat, with soft borders that product and shape widen together."""
    import numpy as np

    low, high = shape["low"], shape["high"]
    if (high if at.is_upper else -low) <= 0:
        return []
    wide = 2 * shape["softness"] * (0.5 + product.edge_softness)
    density = rise(at.across, shape["inner"], 0.38 * wide)
    density = density * fall(at.across, shape["outer"], 0.30 * wide)
    height, beyond = at.height, np.maximum(at.across - 1, 0)
    if shape["lift"]:
        height = height - np.float32(shape["lift"] / LID) * beyond
    if at.is_upper or high < 0:
        density = density * fall(height, high, 0.95 * wide * _room(shape))
    if low > 0 or not at.is_upper:
        density = density * rise(height, low, 0.90 * wide * _room(shape))
    else:
        # beyond the corner no lash line ends the colour: it fades the more the further out
        density = density * smooth((height + _SHARP) / (_SHARP + _FADE * wide * beyond))
    return [Coat(product, density)]


def _room(shape: Shape) -> float:
    """A narrow band has narrower borders, or nothing of it would be at full strength."""
    high: float = shape["high"]
    low: float = shape["low"]
    return min(1.0, 0.5 + high - max(low, 0.0))


KIND = Kind(
    name="eyeshadow",
    part="eyes",
    title="Eyes",
    product="Eye-shadow",
    hidden="eyes",
    category=r"(?<![a-z])eye(?![ _-]?(brow|lash|lin))",
    first_rgb=(90, 58, 46),
    finishes=_FINISHES,
    is_read=True,
    follows_color=True,
    remark="a powder, so softer borders and broader highlights",
    dials=(
        Dial("slot", "lid", "Place", "Where the eye-shadow lies.", choices=tuple(_SLOTS)),
        Dial("low", 0.0, "From", "Its lower border: 0 the lash line, 1 the crease, 2 the brow; "
             "below 0 under the eye.", low=-2, high=2),
        Dial("high", 0.93, "To", "Its upper border, in the same heights.", low=-2, high=2.2),
        Dial("inner", 0.11, "Inner", "Its inner border: 0 the inner corner, 1 the outer.",
             low=-0.3, high=1.6),
        Dial("outer", 1.03, "Outer", "Its outer border, a wing beyond 1.", low=-0.3, high=1.6),
        Dial("lift", 0.0, "Lift", "How steeply the wing rises: its slope.", low=-0.5, high=1.5),
        Dial("softness", 0.5, "Softness", "How far its borders fade."),
    ),
    slots={name: dict(zip(_NUMBERS, row, strict=True)) for name, row in _SLOTS.items()},
    most=4,
    order=20,
    shown={"outer": 1.3},
    surface="eyes",
    coats=_coats,
    spared=0.2,
    keep_highlights=0.15,
)  # fmt: skip
