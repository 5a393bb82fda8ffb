"""The numpy twin of paint.cl, in float64."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from makeup_video.kernels.colour import Coding, decode, encode, rounded
from makeup_video.kernels.material_twin import (
    Environment,
    Material,
    Varying,
    bilinear,
    made_up,
    skin_at,
)
from makeup_video.kernels.paint import FAINT, INSIDE, PRODUCT, MadeRegion
from makeup_video.kernels.planes import Rect, fold, spread


@dataclass(frozen=True, slots=True, eq=False)
class Layers:
    """Products that lie over each other on a region, composed at each pixel.

    shares: as in MadeRegion.  numbers: the rows of `layers` of PRODUCT that are in use.
    mean_root: the first three numbers, summed by share over the grid, for an opacity of 1.
    """

    shares: np.ndarray
    numbers: Sequence[Sequence[float]]
    mean_root: Sequence[float]


@dataclass(frozen=True, slots=True, eq=False)
class PaintedRegion:
    """A region of a frame, and the product on it: a MadeRegion whose product is not yet a record.

    to_grid, to_patch: see PRODUCT.
    layers: in place of the material's product, opacity and glint; None for one product.
    """

    rect: Rect
    weight: np.ndarray
    shading: np.ndarray
    normals: np.ndarray
    to_grid: Sequence[float]
    mean: float
    to_patch: Sequence[float]
    environment: Environment
    material: Material
    layers: Layers | None = None

    def made(self) -> MadeRegion:
        """The region as the kernel takes it."""
        numbers, root = np.zeros(PRODUCT["layers"].shape, np.float32), [0.0, 0.0, 0.0]
        count, shares = 0, None
        if self.layers is not None:
            count, shares = len(self.layers.numbers), self.layers.shares
            numbers[:count] = self.layers.numbers
            root = [FAINT * part for part in self.layers.mean_root]
        (product,) = np.array(
            [(self.to_patch, self.to_grid, self.environment.step, self.material.record(), count,
              numbers, root)],
            PRODUCT,
        )  # fmt: skip
        words = self.environment.words
        return MadeRegion(
            self.rect, self.weight, self.shading, self.normals, self.mean, product, words, shares
        )


def paint_twin(
    planes: tuple[np.ndarray, ...],
    regions: Sequence[PaintedRegion],
    coding: Coding,
    block: tuple[int, int],
) -> tuple[np.ndarray, ...]:
    """Paint as `Canvas.paint` does, in float64, and return the new planes."""
    new = tuple(plane.copy() for plane in planes)
    changes: dict[Rect, np.ndarray] = {}  # in the chroma of each pixel
    for region in regions:
        luma, chroma = region.rect.luma(new), region.rect.chroma(new, block)
        before = changes.get(region.rect, 0.0)
        codes = spread(chroma, block, luma.shape) + before
        luma[:], change = region_twin(luma, codes, region, coding)
        changes[region.rect] = before + change
    for rect, change in changes.items():
        fold(rect.chroma(new, block), change, block, coding.max_code)
    return new


def region_twin(
    luma: np.ndarray, chroma: np.ndarray, region: PaintedRegion, coding: Coding
) -> tuple[np.ndarray, np.ndarray]:
    """Paint one region: luma (h, w) and the chroma of each luma pixel (2, h, w), both codes.

    Returns the new luma codes, and the change of chroma (2, h, w).
    """
    codes = np.stack([luma, *chroma], axis=-1).astype(np.float64)
    coarse, nx, ny, *exposed = on_pixels(region)
    environment = region.environment.linear()
    skin = skin_at(coarse, region.mean, nx, ny, environment, region.material, *exposed)
    weight = region.weight.astype(np.float64)
    u, v = _mapped(region.to_patch, luma.shape)
    layers = region.layers
    varying = None if layers is None else composed(layers, _sampled(layers.shares, region))
    light = made_up(decode(codes, coding), weight, u, v, skin, region.material, varying)
    new = np.where(weight[..., None] > 0, encode(light, coding), codes)
    changed = np.moveaxis((new - codes)[..., 1:], -1, 0)
    return rounded(new[..., 0], coding).astype(luma.dtype), changed


def composed(layers: Layers, shares: np.ndarray) -> Varying:
    """Compose layers: the twin of paint_compose.  shares: (N, ...) at any places."""
    sums = np.einsum("n...,nk->...k", shares, np.array(layers.numbers, np.float64))
    opacity = sums[..., 3]
    root = sums[..., :3] + FAINT * np.array(layers.mean_root)
    root /= (opacity + FAINT)[..., None]
    return Varying(root * root, opacity, sums[..., 4:7], sums[..., 7])


def on_pixels(region: PaintedRegion) -> np.ndarray:
    """Sample shading and normals at each pixel of the rectangle: (3 or 4, h, w)."""
    return _sampled(np.concatenate([region.shading[None], region.normals]), region)


def _sampled(grid: np.ndarray, region: PaintedRegion) -> np.ndarray:
    """Sample (C, H, W) on the region's grid at each pixel of the rectangle: (C, h, w)."""
    x, y = _mapped(region.to_grid, region.weight.shape)
    high, wide = grid.shape[1:]
    x, y = np.clip(x, 0, wide - INSIDE), np.clip(y, 0, high - INSIDE)
    return np.moveaxis(bilinear(grid.astype(np.float64), x, y), -1, 0)


def _mapped(to: Sequence[float], hw: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Map each pixel by a (2, 3) map, given by rows: x and y, (h, w) float32."""
    y, x = np.mgrid[: hw[0], : hw[1]].astype(np.float32)
    a, b, c, d, e, f = np.array(to, np.float32)
    return a * x + b * y + c, d * x + e * y + f
