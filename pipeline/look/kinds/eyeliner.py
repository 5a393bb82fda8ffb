"""Eyeliner: a line along the lashes, with a wing."""

import math

import numpy as np
from makeup_video.pipeline.look.kinds.fields import LID_RISE_AT, EyeFields
from makeup_video.pipeline.look.kinds.kind import Coat, Dial, Kind, Shape
from makeup_video.pipeline.look.kinds.ramps import fall, rise
from makeup_video.pipeline.look.params import GraphicsParams

# Rows in the order of SETTINGS.
_FINISHES = {
    "matte":    (0.95, 0.00, 0.90, 0.00, 0.20, 0.20, 0.00, 0.20, 0.20, 0.90, 0.00, 0.50, 0.50, 1.0),
    "satin":    (0.95, 0.10, 0.60, 0.00, 0.20, 0.20, 0.00, 0.20, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.50, 0.00, 0.80, 0.00, 0.50, 0.50, 0.10, 0.20, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.97, 0.60, 0.35, 0.10, 0.20, 0.20, 0.00, 0.20, 0.50, 0.40, 0.00, 0.50, 0.50, 1.0),
    "metallic": (0.97, 0.60, 0.50, 0.10, 0.20, 0.20, 0.00, 0.20, 0.50, 0.50, 0.40, 0.10, 1.00, 1.0),
    "shimmer":  (0.85, 0.30, 0.60, 0.05, 0.30, 0.30, 0.00, 0.20, 0.50, 0.60, 0.60, 0.20, 0.60, 1.0),
}  # fmt: skip
_OPEN = 0.36  # an open eye's height, of its width: a blink leaves the line as thick as it was
_OVER = 0.03  # of the width: how far the line reaches over the lash line, where the lashes grow
_SLIM = 1.7  # power by which a wing thins to its tip: 1 is a triangle
_LOWER = 0.6  # thickness of the lower line by that of the upper one


def _coats(at: EyeFields, product: GraphicsParams, shape: Shape) -> list[Coat]:
    """The upper line, the wing and the lower line, as the largest of their coverages."""
    thick_px = shape["thickness"] * _OPEN * at.width_px
    smudge = shape["softness"] * (0.5 + product.edge_softness) * 2
    blur_px = np.maximum(at.step_px, smudge * thick_px)
    over_px = np.minimum(_OVER * at.width_px, 0.5 * thick_px)
    # thin at the inner corner, full from the middle of the eye on
    grows = 0.3 + 0.7 * np.clip(at.across * 1.4, 0, 1)
    ends = rise(at.across, 0.02, 0.08) * fall(at.across, 1.0, 0.04)
    line = _covered(at.above_px, -over_px, thick_px * grows, blur_px) * ends
    if shape["wing"] > 0:
        line = np.maximum(line, _wing(at, shape, over_px, thick_px, blur_px))
    if shape["lower"] > 0:
        reach = rise(at.across, 1 - shape["lower"], 0.25) * fall(at.across, 1.0, 0.06)
        low = _covered(at.below_px, -0.5 * over_px, _LOWER * thick_px * reach, blur_px)
        line = np.maximum(line, low * (reach > 0))
    return [Coat(product, line.astype(np.float32))]


def _wing(
    at: EyeFields, shape: Shape, over_px: np.ndarray, thick_px: np.ndarray, blur_px: np.ndarray
) -> np.ndarray:
    """A slim triangle: its lower side runs from the outer corner to the tip, its upper side from the
    tip back to the upper border of the line, so that both are one stroke."""
    length_px = shape["wing"] * at.width_px
    angle = math.radians(shape["wing_angle"])
    out_px, rise_px = (at.across - 1) * at.width_px, at.rise_px
    along, beside = _turned(out_px, rise_px, angle)
    back_px = (LID_RISE_AT - 1) * at.width_px
    back, height = _turned(back_px, at.lid_rise_px + thick_px, angle)
    left = np.clip((length_px - along) * (1 / (length_px - back)), 0, 1)
    wing = _covered(beside, -over_px, np.maximum(height, thick_px) * left**_SLIM, blur_px)
    wing = wing * np.clip((along - back) * (1 / blur_px), 0, 1) * (left > 0)
    return wing * np.clip((at.above_px + over_px) * (1 / blur_px), 0, 1)


def _turned(out: np.ndarray, up: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Along a direction that rises outwards by an angle, and beside it."""
    cos, sin = math.cos(angle), math.sin(angle)
    return out * cos + up * sin, up * cos - out * sin


def _covered(
    at_px: np.ndarray, low_px: np.ndarray | float, high_px: np.ndarray, blur_px: np.ndarray
) -> np.ndarray:
    """The share of a window, blur_px wide around each place, that lies between two borders: a line
    thinner than a pixel is faint, and does not crawl."""
    half = 0.5 * blur_px
    inside = np.minimum(high_px, at_px + half) - np.maximum(low_px, at_px - half)
    return np.clip(inside * (1 / blur_px), 0, 1)


KIND = Kind(
    name="eyeliner",
    part="liner",
    title="Liner",
    product="Eyeliner",
    hidden="eyes",
    category=r"(?<![a-z])eye[ _-]?lin|kajal|kohl",
    first_rgb=(18, 14, 14),
    first_finish="matte",
    finishes=_FINISHES,
    remark="a dense line, so hardly any skin shows through",
    dials=(
        Dial("thickness", 0.14, "Thickness", "How thick the line is.", unit="of the eye's height"),
        Dial("wing", 0.0, "Wing", "How far the wing reaches beyond the outer corner.",
             unit="of the eye's width"),
        Dial("wing_angle", 30.0, "Wing's angle", "How steeply the wing rises.", low=-30, high=75,
             unit="degrees"),
        Dial("lower", 0.0, "Lower line", "How much of the lower lash line is drawn, from the outer "
             "corner on."),
        Dial("softness", 0.1, "Softness", "How smudged the line is."),
    ),
    order=30,
    surface="eyes",
    coats=_coats,
    is_line=True,
    keep_highlights=0.1,
)  # fmt: skip
