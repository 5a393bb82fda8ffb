"""Eyes: the irises keep looking at the camera as the head turns, and the lids blink.

In a blink the upper lid's skin is drawn down over the eye, its lash line kept in shape.

All positions are canvas pixels.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from picture import SCALE, Image, blur, smoothstep

# From the outer to the inner corner, upper then lower lid margin.
LIDS = {
    "right": ([33, 246, 161, 160, 159, 158, 157, 173, 133],
              [33, 7, 163, 144, 145, 153, 154, 155, 133]),
    "left": ([263, 466, 388, 387, 386, 385, 384, 398, 362],
             [263, 249, 390, 373, 374, 380, 381, 382, 362]),
}  # fmt: skip
# The rows of points above the lid, with their share of the lid's movement.
FOLLOW = {
    "right": {0.55: [247, 30, 29, 27, 28, 56, 190], 0.2: [113, 225, 224, 223, 222, 221, 189]},
    "left": {0.55: [467, 260, 259, 257, 258, 286, 414], 0.2: [342, 445, 444, 443, 442, 441, 413]},
}
IRISES = {"right": [468, 469, 470, 471, 472], "left": [473, 474, 475, 476, 477]}
REACH = 9.0 * SCALE  # how far above the lid its skin is drawn from
LASHES = 1.3 * SCALE  # the band above the margin that moves without stretching
LASH_COLOUR = np.float32([0.20, 0.135, 0.11])
RIM = 0.5 * SCALE  # how far below the margin points the lid's dark edge reaches


class Eyes:
    """Renders both eyes and moves their points."""

    def __init__(self, points: NDArray[np.float32]) -> None:
        self.eyes = [_Eye(points, *LIDS[name], points[IRISES[name][0], :2]) for name in LIDS]

    def render(self, sheet: Image, shut: float, gaze: float) -> Image:
        """Return the upper sheet, (H, W, 5), with blinking lids and turned eyes.

        shut: how far the lids are down, 0..1.  gaze: degrees to the right of the picture.
        """
        out = sheet.copy()
        for eye in self.eyes:
            out[eye.box][..., :4] = eye.render(sheet[..., :4].copy(), shut, gaze)
        return out

    def move_points(
        self, points: NDArray[np.float32], shut: float, gaze: float
    ) -> NDArray[np.float32]:
        """Move the irises, the lid margins and the skin above them."""
        out = points.copy()
        for iris in IRISES.values():
            out[iris, 0] += _iris_shift(gaze)
        for eye, name in zip(self.eyes, LIDS, strict=True):
            upper, lower = LIDS[name]
            x = points[upper, 0]
            out[upper, 1] += eye.drop(x, shut)
            out[lower, 1] -= eye.rise(points[lower, 0], shut)
            for share, row in FOLLOW[name].items():
                out[row, 1] += share * eye.drop(points[row, 0], shut)
        return out


class _Eye:
    def __init__(self, points: NDArray, upper: list[int], lower: list[int], iris: NDArray) -> None:
        order = np.argsort(points[upper, 0])
        self.upper, self.lower = points[upper][order, :2], points[lower][order, :2]
        x0, x1 = self.upper[[0, -1], 0] + [-14, 14]
        y0, y1 = self.upper[:, 1].min() - REACH - 8, self.lower[:, 1].max() + 16
        self.box = slice(int(y0), int(y1)), slice(int(x0), int(x1))
        self.ys, self.xs = np.mgrid[self.box].astype(np.float32)
        self.top = _curve(self.upper, self.xs[0])
        self.looks = self._mobile(iris)
        self.noise = blur(np.random.default_rng(5).standard_normal(self.xs.shape, np.float32), 0.9)

    def _gap(self, x: NDArray) -> NDArray[np.float32]:
        return np.maximum(_curve(self.lower, x) - _curve(self.upper, x), 0)

    def drop(self, x: NDArray, shut: float) -> NDArray[np.float32]:
        """Return how far the upper margin moves down at columns x."""
        return 0.9 * shut * self._gap(x)

    def rise(self, x: NDArray, shut: float) -> NDArray[np.float32]:
        """Return how far the lower margin moves up at columns x."""
        return 0.14 * shut * self._gap(x)

    def _mobile(self, iris: NDArray) -> NDArray[np.float32]:
        """Return a weight: 1 where the iris moves as a whole, 0 at the lids and corners."""
        across = np.abs(self.xs - iris[0]) / SCALE
        low = _curve(self.lower, self.xs[0])[None]
        inside = np.minimum(self.ys - self.top[None], low - self.ys) / SCALE
        return smoothstep(8.0, 3.4, across) * smoothstep(-0.9, 0.5, inside)

    def render(self, sheet: Image, shut: float, gaze: float) -> Image:
        """Return the box of the sheet with this eye turned by gaze and its lids shut by 0..1."""
        looking = sheet[self.box].copy()
        if gaze:
            from_x = self.xs - _iris_shift(gaze) * self.looks
            looking = cv2.remap(sheet, from_x, self.ys, cv2.INTER_CUBIC)
        if shut <= 0:
            return looking
        sheet[self.box] = looking
        top, drop = self.top[None], self.drop(self.xs[0], shut)[None]
        high, still = top - REACH, top - LASHES
        # Skin between brow and lashes stretches, most close to the lashes.
        t = np.clip((self.ys - high) / (still + drop - high), 0, 1)
        k = (still + drop - high) / (still - high)
        bent = np.where(k < 1.85, k * t - (k - 1) * t * t, 0)
        skin = high + (still - high) * bent
        source = np.where(self.ys < high, self.ys, np.where(t < 1, skin, self.ys - drop))
        lid = cv2.remap(sheet, self.xs, source.astype(np.float32), cv2.INTER_CUBIC)
        lid[..., :3] = self._bare(lid[..., :3], top + drop, shut)
        rise = self.rise(self.xs[0], shut)[None]
        near = smoothstep(14, 0, np.abs(self.ys - _curve(self.lower, self.xs[0])[None]))
        below = cv2.remap(sheet, self.xs, self.ys + rise * near, cv2.INTER_CUBIC)
        rim = top + drop + RIM * (1 + 0.9 * shut)
        # The white of the eye right under the margin must not move down with the lid.
        line = smoothstep(-3.4, -1.4, self.ys - rim) * min(1.0, 4 * shut)
        line = (0.9 * line * smoothstep(1.0, 10.0, drop / shut))[..., None]
        lid[..., :3] = lid[..., :3] * (1 - line) + LASH_COLOUR * line
        cover = smoothstep(1.1, -1.1, self.ys - rim)[..., None]
        lash = smoothstep(5, 0, self.ys - rim)[..., None]
        below[..., :3] *= 1 - 0.35 * lash * smoothstep(0, 4, drop)[..., None]
        return lid * cover + below * (1 - cover)

    def _bare(self, skin: Image, margin: NDArray, shut: float) -> Image:
        """Return the unfolded lid: smooth skin over the crease, lighter on the bulge."""
        way = np.maximum(self.drop(self.xs[0], 1.0), 1e-3)[None]
        up = (margin - LASHES * 0.8 - self.ys) / way
        there = smoothstep(0.0, 0.3, up) * smoothstep(1.7, 0.9, up) * smoothstep(2, 12, way)
        row = np.clip(self.top - REACH * 0.62 - self.box[0].start, 0, None).astype(int)
        tone = cv2.GaussianBlur(blur(skin, 6)[row, np.arange(skin.shape[1])][None], (0, 0), 9)
        tone = tone * np.float32([0.93, 0.89, 0.87])
        bulge = 0.90 + 0.14 * np.exp(-(((up - 0.45) / 0.4) ** 2))
        plain = tone * (bulge + 0.012 * self.noise)[..., None]
        mix = (0.85 * shut * blur(there, 2.0))[..., None]
        return (skin * (1 - mix) + plain * mix).astype(np.float32)


def _iris_shift(gaze: float) -> float:
    """Return how far the iris of an average eyeball moves to the right, in canvas pixels."""
    return 8.2 * SCALE * float(np.sin(np.radians(gaze)))


def _curve(line: NDArray, x: NDArray) -> NDArray[np.float32]:
    """Return the y of a lid margin at columns x: a smooth curve, flat beyond its points."""
    wide = np.interp(x[:, None] + np.linspace(-4, 4, 9), line[:, 0], line[:, 1])
    return wide.mean(-1).astype(np.float32)
