"""Draws the inside of the mouth: two rows of teeth, gums, tongue and the dark behind.

The drawing replaces the photograph's own teeth. x and y are picture pixels.
"""

from __future__ import annotations

import numpy as np
from motion import State
from numpy.typing import NDArray
from picture import Image, blur, smoothstep, to_canvas

MIDDLE = 222.3  # between the two middle upper teeth
# Half rows from the middle outwards: widths of the visible faces of the teeth.
UPPER_WIDTHS = (5.1, 3.9, 3.5, 2.7, 2.2, 1.8)
UPPER_SHORTER = np.array([0.0, 0.55, 0.15, 0.6, 0.8, 1.0])  # than the middle ones
LOWER_WIDTHS = (3.2, 3.3, 3.1, 2.5, 2.2, 1.7)
DARK = np.float32([0.115, 0.035, 0.030])
GUM = np.float32([0.70, 0.40, 0.38])
TOOTH = np.float32([0.97, 0.925, 0.855])
TONGUE = np.float32([0.74, 0.40, 0.40])


class Interior:
    """Draws what is visible between the lips."""

    def render(self, state: State, gap: Image, xs: Image, ys: Image) -> Image:
        """Return the colours (h, w, 3) behind the lips at canvas positions xs, ys.

        gap: the softened mask of the opening. Little light enters a narrow opening. The teeth lie
        behind the lips, so they shift slightly against the lips as the head turns.
        """
        zero, one = to_canvas(np.array([[0.0, 0.0], [1.0, 1.0]]))
        x, y = (xs - zero[0]) / (one[0] - zero[0]), (ys - zero[1]) / (one[1] - zero[1])
        x = x + 0.055 * state.pose.yaw
        drop = 10.8 * state.jaw
        out = np.broadcast_to(DARK, (*x.shape, 3)).copy()
        self._tongue(out, x, y - drop)
        self._row(out, x, y - drop, LOWER_WIDTHS, False)
        self._row(out, x, y, UPPER_WIDTHS, True)
        light = np.clip(0.25 + 0.95 * smoothstep(0.0, 0.8, blur(gap, 5)), 0, 1.04)
        side = np.clip((x - MIDDLE) / 21, -1, 1)
        light *= (1 - 0.85 * smoothstep(0.45, 1.0, np.abs(side))) * (0.98 - 0.10 * side)
        return out * light[..., None]

    @staticmethod
    def _row(out: Image, x: Image, y: Image, widths: tuple[float, ...], upper: bool) -> None:
        """Paint one row of teeth with its gum; y is relative to the row."""
        edges = np.cumsum((0.0, *widths))
        place = np.abs(x - MIDDLE)
        i = np.clip(np.searchsorted(edges, place, "right") - 1, 0, len(widths) - 1)
        bite, gum = _bite(x, upper), _gum(x, upper)
        if upper:  # the shadow of the teeth on everything behind
            bite = bite - UPPER_SHORTER[i]
            out *= 1 - (0.5 * smoothstep(1.6, 0.0, y - bite))[..., None]
        down = (y - gum) / (bite - gum)  # 0 at the gum, 1 at the biting edge
        width = np.array(widths)[i]
        across = (place - edges[i]) / width * 2 - 1  # -1..1 within the tooth
        # Teeth are rounded: narrower near the biting edge and at the gum.
        slim = 0.07 * smoothstep(0.72, 1.02, down) ** 2 + 0.10 * smoothstep(0.35, 0.0, down)
        from_side = (1 - slim - np.abs(across)) * width / 2
        corner = 0.45 * smoothstep(0.62, 1.0, np.abs(across)) ** 1.5 * np.sign(bite - gum)
        from_edge = (bite - corner - y) * np.sign(bite - gum)
        mask = smoothstep(-0.28, 0.22, from_side) * smoothstep(-0.22, 0.22, from_edge)
        mask *= smoothstep(-0.08, 0.05, down) * (place < edges[-1])
        shade = 0.90 + 0.10 * np.sqrt(np.clip(1 - across**2, 0, 1))
        shade = shade * (1 - 0.10 * smoothstep(0.75, 1.0, down)) * (0.98 if upper else 0.84)
        shade += 0.06 * np.exp(-(((across + 0.25) / 0.3) ** 2) - ((down - 0.55) / 0.25) ** 2)
        tint = TOOTH * (1 - 0.10 * smoothstep(2.0, 4.0, i.astype(np.float32)))[..., None]
        flesh = (
            smoothstep(0.12, -0.10, down) * (place < edges[-1] + 2) * smoothstep(-1.4, -0.2, down)
        )
        between = (
            smoothstep(-0.1, 0.2, from_edge) * smoothstep(0.0, 0.2, down) * (place < edges[-1])
        )
        out *= 1 - (0.2 * between)[..., None]
        out += np.float32([0.62, 0.47, 0.37]) * (between * 0.8)[..., None]
        out[:] = out * (1 - flesh[..., None]) + GUM * (flesh * 0.85)[..., None]
        out[:] = out * (1 - mask[..., None]) + tint * (shade * mask)[..., None]

    @staticmethod
    def _tongue(out: Image, x: Image, y: Image) -> None:
        """Paint the tongue, resting behind the lower teeth."""
        rx, ry = (x - MIDDLE) / 13.0, (y - 150.0) / 7.5
        r = np.sqrt(rx**2 + ry**2)
        mask = smoothstep(1.06, 0.86, r)
        groove = 1 - 0.22 * np.exp(-(((x - MIDDLE) / 0.9) ** 2))
        shade = groove * np.clip(0.78 + 0.45 * ry, 0.25, 1) * (1 - 0.35 * r**4).clip(0.3, 1)
        out[:] = out * (1 - mask[..., None]) + TONGUE * (mask * shade)[..., None]


def _bite(x: NDArray, upper: bool) -> NDArray:
    """Return the y of the biting edge. The upper row follows the smile; the lower is flatter."""
    u = x - MIDDLE
    return 148.9 - 0.0125 * u**2 if upper else 147.6 - 0.006 * u**2


def _gum(x: NDArray, upper: bool) -> NDArray:
    """Return the y of the gum line."""
    u = x - MIDDLE
    return 142.4 - 0.004 * u**2 if upper else 154.2 - 0.008 * u**2
