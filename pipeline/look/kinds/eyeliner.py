"""Eyeliner: a line along the lashes, with a wing."""

import math
from functools import lru_cache
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
_OPEN = 0.36  # an open eye's height, in widths; fixed, so that a blink does not change the line
_OVER = 0.03  # how far the line reaches over the lash line, where lashes grow, in widths of the eye
_SLIM = 1.7  # power by which a wing thins to its tip: 1 is a triangle
# How round a wing is where it begins, below the outer corner of an open eye, in widths of the eye.
_ROUND, _LEAST_ROUND = 0.08, 1e-3
_FULL_WING = 0.08  # thickness from which on a wing is as high as the lid's rise lets it be
# `across` where the upper line ends, and the length over which it thins there: as a multiple of its
# thickness, at least, at most; in widths of the eye.
_END, _THINS, _LEAST_THINNING, _MOST_THINNING = 1.04, 1.6, 0.06, 0.2
# A wing of at least this length takes over from the upper line, which then ends earlier: otherwise
# the line would be a barb below the wing. A lower line of this length meets both in the corner.
_LONG, _END_AT_WING = 0.1, 0.96
_THINNED = -1e3  # px: no line at all
_SHORTEST_PX = 0.01  # least length of a wing, so that nothing divides by zero
_BELOW = -0.3  # where the lower line begins below the lashes, as a multiple of `over`
_LOWER = 0.6  # thickness of the lower line, as a share of the upper line's


def _coats(at: EyeFields, product: GraphicsParams, shape: Shape) -> list[Coat]:
    """The upper line with its wing, and the lower line."""
    thick = shape["thickness"] * _OPEN
    over = min(_OVER, 0.5 * thick)
    over_px = over * at.width_px
    upper, before_wing, lower = _columns(at.across.tobytes(), thick, over, shape["lower"])
    if shape["wing"] > 0 and thick > 0:
        free = _opened(at) * max(1 - shape["lower"] / _LONG, 0)
        upper = upper + min(shape["wing"] / _LONG, 1) * free * (before_wing - upper)
        line = _along(at.above_px, over_px, _thickness_px(upper, at))
        strokes = [line, _wing(at, shape, line, over_px, thick * at.width_px, free)]
    else:
        strokes = [_along(at.above_px, over_px, _thickness_px(upper, at))]
    if shape["lower"] > 0:
        in_eye_px = _in_eye(at.across.tobytes()) * over_px
        strokes.append(_along(at.below_px, in_eye_px, _thickness_px(lower, at)))
    smudge = shape["softness"] * (0.5 + product.edge_softness) * 2
    blur_px = max(1.0, smudge * thick * float(at.width_px.max()))
    return [Coat(product, strokes=tuple(strokes), blur_px=blur_px)]


@lru_cache(maxsize=16)
def _columns(
    across: bytes, thick: float, over: float, lower: float
) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
    """Thicknesses of lines by column of the grid, (48,) each, in widths of the eye; 0 for no line.

    Returns those of the upper line, of an upper line from which a wing takes over, and of the lower
    line.  across: the bytes of EyeFields.across, float32.
    """
    import numpy as np

    at = np.frombuffer(across, np.float32)
    # thin at the inner corner, full from the middle of the eye on
    here = thick * (0.15 + 0.85 * np.clip(at * 1.25, 0, 1)) + over
    thins = min(max(_THINS * thick, _LEAST_THINNING), _MOST_THINNING)
    here = here * rise(at, 0.08, 0.16)
    upper, before_wing = (here * fall(at, end - thins / 2, thins) for end in (_END, _END_AT_WING))
    reach = rise(at, max(1 - lower, 0.16), 0.25) * fall(at, 1.0, 0.06)
    lines = upper, before_wing, _LOWER * thick * reach
    first, second, third = (line.astype(np.float32) for line in lines)
    return first, second, third


@lru_cache(maxsize=16)
def _in_eye(across: bytes) -> "np.ndarray":
    """(48,): how far the lower line begins within the eye, as a multiple of `over`.

    The line lies below the lashes, otherwise it would rim the eyeball. In the outer corner it meets
    the upper line.  across: the bytes of EyeFields.across, float32.
    """
    import numpy as np

    at = np.frombuffer(across, np.float32)
    in_eye: np.ndarray = _BELOW + (0.5 - _BELOW) * rise(at, 0.96, 0.12)
    return in_eye.astype(np.float32)


def _thickness_px(columns: "np.ndarray", at: EyeFields) -> "np.ndarray":
    """(N, 1, 48) float32: thickness of a line; far below 0 where there is none."""
    thick_px: np.ndarray = columns * at.width_px
    thick_px[thick_px <= 0] = _THINNED
    return thick_px


def _along(away_px: "np.ndarray", over_px: "np.ndarray", thick_px: "np.ndarray") -> Stroke:
    """A stroke along a lash line; it begins over_px beyond the line."""
    above = away_px + over_px
    return Stroke(above, thick_px - above)


def _opened(at: EyeFields) -> "np.ndarray":
    """(N, 1, 1) float32: 1 for an open eye, 0 for a shut one."""
    import numpy as np

    open_px = -(at.above_px + at.below_px).min((1, 2), keepdims=True)
    opened: np.ndarray = open_px / (0.5 * _OPEN * at.width_px)
    np.minimum(np.maximum(opened, 0, out=opened), 1, out=opened)
    return opened


def _wing(
    at: EyeFields,
    shape: Shape,
    line: Stroke,
    over_px: "np.ndarray",
    thick_px: "np.ndarray",
    free: "np.ndarray",
) -> Stroke:
    """A slim triangle: its lower side runs from the outer corner to the tip, its upper side from
    the tip back to the upper border of the line, so that both look like one stroke. A wing is round
    where it begins. Where a lower line meets the wing, or on a shut eye, it is not round, and its
    lower side goes on from the lash line.

    free: (N, 1, 1) float32, 1 where the wing is round.
    """
    import numpy as np

    wide_px, length, angle = at.width_px, shape["wing"], math.radians(shape["wing_angle"])
    along, beside, left, beyond = _wing_places(
        at.across.tobytes(), at.rise.tobytes(), length, angle
    )
    back, height = _turned((LID_RISE_AT - 1) * wide_px, at.lid_rise_px + thick_px, angle)
    back = np.minimum(back, 0)  # otherwise a steep wing would begin beyond its tip
    # never on the eyeball, nor before the place where the wing leaves the line
    beside_px = beside * wide_px
    beside_px += over_px
    above = along * wide_px
    above -= back
    round_px = np.maximum(_ROUND * free, _LEAST_ROUND) * wide_px
    np.minimum(above, _rounded(beside_px, line.above, round_px), out=above)
    share = wide_px / np.maximum(length * wide_px - back, _SHORTEST_PX)
    below = left * share**_SLIM
    np.minimum(below, 1, out=below)
    below *= np.maximum(height * min(shape["thickness"] / _FULL_WING, 1), thick_px) + over_px
    below -= beside_px
    below += beyond
    return Stroke(above, below)


def _rounded(a: "np.ndarray", b: "np.ndarray", wide: "np.ndarray") -> "np.ndarray":
    """The smaller of two numbers, and less than that where both are nearly equal: two straight
    borders then meet in a round corner (the polynomial smooth minimum of Quilez).

    wide: the difference of the numbers where the corner ends.
    """
    import numpy as np

    alike = a - b
    np.abs(alike, out=alike)
    np.subtract(wide, alike, out=alike)
    np.maximum(alike, 0, out=alike)
    alike *= alike
    alike *= 0.25 / wide
    rounded: np.ndarray = np.minimum(a, b)
    rounded -= alike
    return rounded


@lru_cache(maxsize=16)
def _wing_places(
    across: bytes, rise: bytes, length: float, angle: float
) -> "tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]":
    """Where the grid's places lie by a wing, (32, 48) float32 each, the same for all faces.

    Returns how far a place lies along the wing and beside it, in widths of the eye; the distance
    that is left to the tip, to the power by which wings thin; and 0, or far below 0 beyond the tip.
    across, rise: the bytes of these arrays of EyeFields, float32.
    """
    import numpy as np

    out, up = np.frombuffer(across, np.float32) - 1, np.frombuffer(rise, np.float32)[:, None]
    along, beside = _turned(out, up, angle)
    left = np.maximum(length - along, 0)
    beyond = np.where(left > 0, np.float32(0), np.float32(_THINNED))
    return along, beside, left**_SLIM, beyond


def _turned(out: "np.ndarray", up: "np.ndarray", angle: float) -> "tuple[np.ndarray, np.ndarray]":
    """How far places lie along a direction that rises outwards by an angle, and beside it."""
    cos, sin = math.cos(angle), math.sin(angle)
    return out * cos + up * sin, up * cos - out * sin


KIND = Kind(
    name="eyeliner",
    part="liner",
    title="Liner",
    product="Eyeliner",
    words=("liners", "eye liner", "eye liners", "kajal", "kohl"),
    must_see="eyes",
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
    region="eyes",
    coats=_coats,
    is_line=True,
    keep_highlights=0.1,
)  # fmt: skip
