"""Expressions: the jaw drops, the lips part and close, the lids come down.

One sheet is not enough: upper and lower lip move apart, and the chin slides over the neck. So the
head picture is split into three sheets: the neck (still), everything below the mouth line (lower)
and the rest (upper). They are laid over each other, with the inside of the mouth between them. All
positions are canvas pixels; shifts are set in picture pixels.
"""

from __future__ import annotations

import cv2
import numpy as np
from eyes import Eyes
from head import JAW_LINE, STEP, Field, grid, invert, sample
from interior import Interior
from motion import State
from numpy.typing import NDArray
from picture import HEIGHT, SCALE, WIDTH, Image, blur, smoothstep, spread
from shapes import CORNERS, LOWER, RINGS, SHAPES, UPPER, field, lower_points, shape

TINT = np.float32([0.75, 1.0, 1.0])  # the shade between lips is reddish


class Face:
    """Renders the head layer with an expression."""

    def __init__(self, head: Image, points: NDArray[np.float32]) -> None:
        self.points, self.head = points, head
        self.eyes = Eyes(points)
        self.interior = Interior()
        lower = lower_points(points)
        self.is_lower = lower
        moves = {name: shape(name, points, lower) for name in SHAPES}
        # Beside the mouth both sheets must move alike, or the cheeks would tear.
        half = np.ptp(points[CORNERS, 0]) / 2
        beside = np.abs(points[:, 0] - points[CORNERS, 0].mean()) > 1.04 * half
        up = [i for i in range(468) if not lower[i] or beside[i]]
        upper_lip = {i for ring in UPPER for i in ring}
        low = [i for i in range(468) if i not in upper_lip]
        self.upper = {n: field(points, up, m) for n, m in moves.items()}
        self.lower = {n: field(points, low, m) for n, m in moves.items()}
        self.sheets = _sheets(head, points)
        ys, xs = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
        self.box = _box(points)
        self.xs, self.ys = xs[self.box], ys[self.box]
        inner = points[RINGS[3], :2]
        middle = (self.xs - inner[:, 0].mean()) / (np.ptp(inner[:, 0]) / 2)
        self.near_mouth = smoothstep(1.06, 0.82, np.abs(middle))

    def fields(self, state: State) -> tuple[Field, Field]:
        """Return the forward fields of the upper and the lower sheet."""
        gains = {n: getattr(state, n) for n in SHAPES}
        upper = sum(gains[n] * f for n, f in self.upper.items())
        lower = sum(gains[n] * f for n, f in self.lower.items())
        return upper, lower

    def move_points(self, state: State) -> NDArray[np.float32]:
        """Return the 478 face points, (478, 3), with the expression, before the head turns."""
        out = self.eyes.move_points(self.points, state.lids, state.gaze).astype(np.float32)
        x, y = out[:, 0].copy(), out[:, 1].copy()
        upper, lower = (sample(f, x, y) for f in self.fields(state))
        out[:, :2] += np.where(self.is_lower[:, None], lower, upper)
        return out

    def render(self, state: State) -> Image:
        """Return the head layer with the expression, premultiplied RGBA (HEIGHT, WIDTH, 4)."""
        upper_field, lower_field = self.fields(state)
        upper = self._sheet(self.eyes.render(self.sheets[0], state.lids, state.gaze), upper_field)
        lower = self._sheet(self.sheets[1], lower_field)
        cover, lip = upper[..., 4:], np.maximum(lower[..., 4:], self._beside(upper_field))
        gap = blur((1 - cover[..., 0]) * (1 - lip[..., 0]), 2.0)
        mouth = self.interior.render(state, gap, self.xs, self.ys)
        # Each lip shades the other where they meet; the upper one hangs over the lower.
        dark = blur(cover[..., 0], 3.2)[..., None] * self.near_mouth[..., None]
        shaded = lower[..., :3] * (1 - 0.55 * dark * TINT)
        curl = blur(1 - cover[..., 0], 2.6)[..., None] * self.near_mouth[..., None]
        overhang = upper[..., :3] * (1 - 0.40 * curl * TINT)
        crease = 4 * cover * (1 - cover) * lip * self.near_mouth[..., None]
        chin = self._chin_edge(lower_field)
        neck = self.head[self.box]
        under = neck[..., :3] * (1 - 0.30 * state.jaw * blur(chin, 9)[..., None])
        out = under * (1 - chin[..., None]) + mouth * chin[..., None]
        out = out * (1 - lip) + shaded * lip
        out = (out * (1 - cover) + overhang * cover) * (1 - 0.35 * crease * TINT)
        alpha = neck[..., 3:] * (1 - chin[..., None]) + chin[..., None]
        alpha = alpha * (1 - lip) + lower[..., 3:4] * lip
        alpha = alpha * (1 - cover) + upper[..., 3:4] * cover
        result = self.head.copy()
        result[self.box] = np.dstack([out, alpha])
        return result

    def _sheet(self, sheet: Image, field: Field) -> Image:
        """Move a sheet by its forward field and cut it to the box, (h, w, 5)."""
        x, y = self._source(field)
        four = cv2.remap(sheet[..., :4], x, y, cv2.INTER_CUBIC)
        mask = cv2.remap(sheet[..., 4], x, y, cv2.INTER_LINEAR)
        return np.dstack([four, mask])

    def _source(self, field: Field) -> tuple[Image, Image]:
        """Return the source positions of the box's pixels at full resolution."""
        rows, columns = self.box
        part = (slice(rows.start // STEP, rows.stop // STEP),
                slice(columns.start // STEP, columns.stop // STEP))  # fmt: skip
        gx, gy = grid()
        x, y = invert(field, gx[part], gy[part], 14)
        dx, dy = x - gx[part], y - gy[part]
        # Field samples lie on every STEP-th pixel, not in the middle of STEP x STEP blocks.
        fx = (self.xs - columns.start) / STEP
        fy = (self.ys - rows.start) / STEP
        wide = (cv2.remap(d, fx, fy, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
                for d in (dx, dy))  # fmt: skip
        return tuple(p + d for p, d in zip((self.xs, self.ys), wide, strict=True))

    def _beside(self, field: Field) -> Image:
        """Return 1 beside the moved corners of the mouth, where no opening can be, (h, w, 1)."""
        corners = self.points[[RINGS[3][0], RINGS[3][10]], :2]
        shift = sample(field, corners[:, 0].copy(), corners[:, 1].copy())
        left, right = corners[:, 0] + shift[:, 0]
        out = np.maximum(left - self.xs, self.xs - right)
        return smoothstep(0.0, 5.0, out)[..., None]

    def _chin_edge(self, field: Field) -> Image:
        """Return 1 above the moved jaw line and 0 below, within the box."""
        line = self.points[JAW_LINE, :2]
        shift = sample(field, line[:, 0].copy(), line[:, 1].copy())
        moved = (line + shift)[np.argsort((line + shift)[:, 0])]
        edge = np.interp(self.xs[0], moved[:, 0], moved[:, 1]).astype(np.float32)
        return smoothstep(2.0, -2.0, self.ys - edge[None])


def _box(points: NDArray) -> tuple[slice, slice]:
    """Return the part of the canvas that expressions change; even bounds match the fields."""
    low, high = points[:468, :2].min(0) - 24, points[:468, :2].max(0) + np.array([24, 70])
    (x0, y0), (x1, y1) = (np.stack([low, high]) // STEP * STEP).astype(int).tolist()
    return slice(y0, min(y1, HEIGHT)), slice(x0, x1)


def _dark_corners(head: Image, line: NDArray) -> NDArray[np.bool_]:
    """Find the dark of the open mouth around its corners, which no sheet may contain."""
    ys, xs = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
    near = np.zeros((HEIGHT, WIDTH), bool)
    for x, y in line[[0, -1]]:
        near |= ((xs - x) / 9) ** 2 + ((ys - y) / 5) ** 2 < SCALE**2
    dark = (head[..., :3].mean(-1) < 0.42) & near
    return cv2.dilate(dark.astype(np.uint8), np.ones((7, 7))) > 0


def _sheets(head: Image, points: NDArray) -> tuple[Image, Image]:
    """Return the upper and lower sheets, (HEIGHT, WIDTH, 5): premultiplied RGBA and mask.

    Each sheet continues the colour of its lip beyond the cut, so that no teeth show at its edge.
    """
    ys, xs = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
    sheets = []
    for rows, sign, inset in ((UPPER, 1, 0.1), (LOWER, -1, 0.1)):
        line = points[[RINGS[3][0], *rows[3], RINGS[3][10]], :2]
        edge = np.interp(xs[0], line[:, 0], line[:, 1]).astype(np.float32)
        edge = cv2.GaussianBlur(edge[None], (0, 0), 4)[0]
        # The inset keeps teeth off the edges of the lips; in the corners the sheets overlap.
        u = 2 * (xs[0] - line[0, 0]) / (line[-1, 0] - line[0, 0]) - 1
        inset = np.where(np.abs(u) < 1, (inset + 0.4) * (1 - u**8) - 0.4, -0.4)
        depth = (edge[None] - ys) * sign - inset[None].astype(np.float32) * SCALE
        if sign < 0:  # beside the mouth the lower sheet lies under the upper one
            beside = np.maximum(line[0, 0] - xs, xs - line[-1, 0])
            depth = np.maximum(depth, np.minimum(beside * 2, 12 - np.abs(depth)))
        known = (depth > 1.0 * SCALE) | (np.abs(ys - edge[None]) > 14 * SCALE)
        known &= ~_dark_corners(head, line)
        known |= np.maximum(line[0, 0] - xs, xs - line[-1, 0]) > 8 * SCALE
        sheets.append(np.dstack([spread(head, known, 2.2), smoothstep(-1.2, 1.2, depth)]))
    return sheets[0], sheets[1]
