"""Eyeliner: a line along the lashes, with a wing."""

import math
from typing import TYPE_CHECKING

from makeup_video.pipeline.look.kinds.fields import LID_RISE_AT, EyeFields
from makeup_video.pipeline.look.kinds.kind import Coat, Dial, Kind, Shape, Stroke
from makeup_video.pipeline.look.kinds.ramps import fall, rise
from makeup_video.pipeline.look.params import GraphicsParams

if TYPE_CHECKING:
    import numpy as np

# Rows in the order of SETTINGS.
_FINISHES = {
    "matte":    (0.95, 0.00, 0.90, 0.00, 0.20, 0.20, 0.00, 0.20, 0.20, 0.90, 0.00, 0.50, 0.50, 1.0),
    "satin":    (0.95, 0.10, 0.60, 0.00, 0.20, 0.20, 0.00, 0.20, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.50, 0.00, 0.80, 0.00, 0.50, 0.50, 0.08, 0.20, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.97, 0.60, 0.35, 0.10, 0.20, 0.20, 0.00, 0.20, 0.50, 0.40, 0.00, 0.50, 0.50, 1.0),
    "metallic": (0.97, 0.60, 0.50, 0.10, 0.20, 0.20, 0.00, 0.20, 0.50, 0.50, 0.40, 0.10, 1.00, 1.0),
    "shimmer":  (0.85, 0.30, 0.60, 0.05, 0.30, 0.30, 0.00, 0.20, 0.50, 0.60, 0.60, 0.20, 0.60, 1.0),
}  # fmt: skip
_OPEN = 0.36  # an open eye's height, of its width: a blink leaves the line as thick as it was
_OVER = 0.03  # of the width: how far the line reaches over the lash line, where the lashes grow
_SLIM = 1.7  # power by which a wing thins to its tip: 1 is a triangle
_THINNED = -1e3  # px: no line at all
_SHORTEST_PX = 0.01  # of a wing, so that none divides by zero
_LOWER = 0.6  # thickness of the lower line by that of the upper one


def _coats(at: EyeFields, product: GraphicsParams, shape: Shape) -> list[Coat]:
    """The upper line with its wing, and the lower line."""
    import numpy as np

    thick_px = shape["thickness"] * _OPEN * at.width_px
    over_px = np.minimum(_OVER * at.width_px, 0.5 * thick_px)
    # thin at the inner corner, full from the middle of the eye on
    here_px = thick_px * (0.15 + 0.85 * np.clip(at.across * 1.25, 0, 1)) + over_px
    ends = rise(at.across, 0.08, 0.16) * fall(at.across, 1.01, 0.06)
    strokes = [_along(at.above_px, over_px, here_px * ends)]
    if shape["wing"] > 0:
        strokes.append(_wing(at, shape, over_px, thick_px))
    if shape["lower"] > 0:
        reach = rise(at.across, max(1 - shape["lower"], 0.16), 0.25) * fall(at.across, 1.0, 0.06)
        strokes.append(_along(at.below_px, 0.5 * over_px, _LOWER * thick_px * reach))
    smudge = shape["softness"] * (0.5 + product.edge_softness) * 2
    blur_px = max(1.0, smudge * float(thick_px.max()))
    return [Coat(product, strokes=tuple(strokes), blur_px=blur_px)]


def _along(away_px: "np.ndarray", over_px: "np.ndarray", thick_px: "np.ndarray") -> Stroke:
    """A stroke along a lash line that begins a little over it."""
    above = away_px + over_px
    none = (thick_px <= 0).astype(above.dtype)
    return Stroke(above, _THINNED * none + thick_px - above)


def _wing(at: EyeFields, shape: Shape, over_px: "np.ndarray", thick_px: "np.ndarray") -> Stroke:
    """A slim triangle: its lower side runs from the outer corner to the tip, its upper side from
    the tip back to the upper border of the line, so that both are one stroke."""
    import numpy as np

    length_px = shape["wing"] * at.width_px
    angle = math.radians(shape["wing_angle"])
    along, beside = _turned((at.across - 1) * at.width_px, at.rise_px, angle)
    back_px = (LID_RISE_AT - 1) * at.width_px
    back, height = _turned(back_px, at.lid_rise_px + thick_px, angle)
    back = np.minimum(back, 0)  # a steep wing begins at the corner, or its tip would lie behind it
    left = np.clip((length_px - along) * (1 / np.maximum(length_px - back, _SHORTEST_PX)), 0, 1)
    high = (np.maximum(height, thick_px) + over_px) * left**_SLIM
    # never on the eyeball, nor before the place where the wing leaves the line
    above = np.minimum(np.minimum(beside, at.above_px) + over_px, along - back)
    none = (left <= 0).astype(above.dtype)
    return Stroke(above, _THINNED * none + high - over_px - beside)


def _turned(out: "np.ndarray", up: "np.ndarray", angle: float) -> "tuple[np.ndarray, np.ndarray]":
    """Along a direction that rises outwards by an angle, and beside it."""
    cos, sin = math.cos(angle), math.sin(angle)
    return out * cos + up * sin, up * cos - out * sin


KIND = Kind(
    name="eyeliner",
    part="liner",
    title="Liner",
    product="Eyeliner",
    words=("liners", "eye liner", "eye liners", "kajal", "kohl"),
    hidden="eyes",
    category=r"(?<![a-z])eye[ _-]?lin|kajal|kohl",
    first_rgb=(18, 14, 14),
    first_finish="matte",
    finishes=_FINISHES,
    is_read=True,
    remark="a dense line, so hardly any skin shows through",
    dials=(
        Dial("thickness", 0.12, "Thickness", "How thick the line is.", unit="of the eye's height"),
        Dial("wing", 0.0, "Wing", "How far the wing reaches beyond the outer corner.",
             unit="of the eye's width"),
        Dial("wing_angle", 30.0, "Wing's angle", "How steeply the wing rises.", low=-30, high=75,
             unit="degrees"),
        Dial("lower", 0.0, "Lower line", "How much of the lower lash line is drawn, from the outer "
             "corner on."),
        Dial("softness", 0.1, "Softness", "How smudged the line is."),
    ),
    order=30,
    shown={"wing": 0.25, "lower": 0.5},
    surface="eyes",
    coats=_coats,
    is_line=True,
    keep_highlights=0.1,
)  # fmt: skip
