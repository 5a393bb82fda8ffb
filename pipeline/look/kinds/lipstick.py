"""Lipstick: even, or coloured in the middle alone, or with a liner's darker rim."""

from dataclasses import replace

from makeup_video.pipeline.look.kinds.fields import LipsFields
from makeup_video.pipeline.look.kinds.kind import Coat, Dial, Kind, Shape
from makeup_video.pipeline.look.kinds.ramps import fall
from makeup_video.pipeline.look.params import GraphicsParams, rgb_of_hex

# Rows in the order of SETTINGS. How much of the lips' lines and folds stays was measured on 115
# photos of matte, satin and glossy lipstick: painted lips are as uneven as the lips there.
_FINISHES = {
    "matte":    (0.96, 0.00, 0.80, 0.00, 0.30, 0.80, 0.00, 0.20, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "satin":    (0.92, 0.40, 0.45, 0.05, 0.35, 0.95, 0.05, 0.50, 0.50, 0.60, 0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.40, 0.30, 0.50, 0.05, 0.60, 0.95, 0.08, 0.60, 0.50, 0.50, 0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.94, 1.30, 0.20, 0.25, 0.40, 0.95, 0.08, 0.55, 0.70, 0.20, 0.00, 0.50, 0.50, 1.0),
    "metallic": (0.95, 2.00, 0.60, 0.30, 0.40, 0.95, 0.00, 0.30, 0.60, 0.40, 0.50, 0.10, 1.00, 1.0),
    "shimmer":  (0.75, 0.60, 0.40, 0.10, 0.50, 0.95, 0.08, 0.50, 0.50, 0.50, 0.60, 0.30, 0.40, 1.0),
}  # fmt: skip
_RIM_WIDTH = 0.34  # share of the way to the middle of the lips


def _coats(at: LipsFields, product: GraphicsParams, shape: Shape) -> list[Coat]:
    """The lipstick, which may fade towards the border, and over it the rim of a lip liner."""
    fade = shape["gradient"]
    # the fade starts at the border and reaches further inwards as it grows
    even = None if fade <= 0 else 1 - fade * fall(at.inward, 0.15 + 0.35 * fade, 0.5 + 0.2 * fade)
    coats = [Coat(product, even)]
    if shape["rim"] > 0:
        red, green, blue = rgb_of_hex(shape["rim_color"]) or (0, 0, 0)
        liner = replace(product, red=red, green=green, blue=blue)
        # a lip liner ends softly inwards, sharply at the border of the lips
        drawn = shape["rim"] * fall(at.inward, 0.6 * _RIM_WIDTH, _RIM_WIDTH)
        coats.append(Coat(liner, drawn))
    return coats


KIND = Kind(
    name="lipstick",
    part="lips",
    title="Lips",
    product="Lipstick",
    words=("lip", "lipsticks", "lip colour", "lip color", "lip gloss", "mouth"),
    must_see="mouth",
    category=r"(?<![a-z])lip",
    first_rgb=(180, 0, 46),
    finishes=_FINISHES,
    is_read=True,
    follows_color=True,
    dials=(
        Dial(
            "gradient", 0.0, "Gradient",
            "How far the colour fades towards the border: 0 is even, 1 leaves it in the middle.",
        ),
        Dial("rim", 0.0, "Rim", "How much lip liner lies along the border."),
        Dial("rim_color", "#5A1A1E", "Rim's colour", "The lip liner's colour.", is_colour=True),
    ),
    order=40,
    region="lips",
    coats=_coats,
    spared=0.17,
    keep_matte=0.2,
)  # fmt: skip
