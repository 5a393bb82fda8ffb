"""Coats on the charts of a region -> how much of each shows at the places of its surfaces.

The numpy twin of kernels/shares.cl, which serves the eyes only. Coats on other regions are always
laid here.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.kernels.shares import FAINTEST
from makeup_video.pipeline.render.blend_layers import shares_of
from makeup_video.pipeline.render.surfaces.surface import Charts, Laid, Surface


def lay_coats(surface: Surface, charts: Charts, opacities: Sequence[float]) -> Laid:
    """Lay coats on all surfaces of a region.

    surface: any surface of the region.  opacities: one for each coat.
    """
    on_sides = zip(surface.sides(), charts.on_sides, strict=True)
    found = [_looked_up(charts, side) for side, chart in on_sides if chart is not None]
    densities = surface.join(found) if len(found) > 1 else found[0]
    if len(densities) == 1:
        return Laid(None, (), densities[0])
    shares = shares_of(densities, opacities)
    return Laid(shares, shares.sum((2, 3)).T.tolist(), _any_of(densities))


def _looked_up(charts: Charts, surface: Surface) -> np.ndarray:
    """Charts (h, w, coats) -> densities (coats, N, H, W) at the places of all N surfaces."""
    x, y = surface.on_chart()
    of_surfaces, hw = surface.charts_of(charts), surface.normals.shape[1:]
    rows = len(y) // len(of_surfaces)
    parts = [
        cv2.remap(
            chart, x[first : first + rows], y[first : first + rows], cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        for first, chart in zip(range(0, len(y), rows), of_surfaces, strict=True)
    ]  # fmt: skip
    found = parts[0] if len(parts) == 1 else np.concatenate(parts)
    if found.ndim == 2:
        return found.reshape(1, -1, *hw)
    maps = np.empty((found.shape[2], *found.shape[:2]), np.float32)
    cv2.split(found, list(maps))
    return maps.reshape(len(maps), -1, *hw)


def _any_of(densities: np.ndarray) -> np.ndarray:
    """(N, H, W): 1 where any of several coats lies, else 0."""
    most = densities.max(0)
    _, there = cv2.threshold(most.reshape(-1, most.shape[-1]), FAINTEST, 1.0, cv2.THRESH_BINARY)
    any_of_them: np.ndarray = there.reshape(most.shape)
    return any_of_them
