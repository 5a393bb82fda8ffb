"""Host side of paint.cl, and its numpy twin."""

from dataclasses import dataclass

import numpy as np
from makeup_video.kernels.colour import Coding, coding_argument, decode, encode, rounded
from makeup_video.kernels.material import Material, made_up, skin_at
from makeup_video.kernels.program import LOCAL_SIZE, Device, stride_of

_REGION = np.dtype(
    [("size", "i4", (2,)), ("luma_stride", "i4"), ("mean", "f4"), ("to_patch", "f4", (6,))]
)


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A region of a frame, pixel by pixel.

    maps: (4, h, w) float32, C order: weight of the product, 0..1; luminance of the bare skin
    without its fine texture, linear; x and y of the unit normal (x right, y down, in the patch; z
    is towards the viewer).  mean: luminance of the bare region.  to_patch: (2, 3), px of the
    region to coordinates that stick to the skin, of at least -4096 and less than 2^23 cells.
    environment: (3, 16, 16) float32, linear.
    """

    maps: np.ndarray
    mean: float
    to_patch: np.ndarray
    environment: np.ndarray


def paint(
    device: Device,
    luma: np.ndarray,
    chroma: np.ndarray,
    surface: Surface,
    material: Material,
    coding: Coding,
) -> None:
    """Paint on a window of a luma plane, in place; chroma becomes the change of chroma.

    luma: (h, w) uint8 or uint16 codes, rows of any stride.  chroma: (2, h, w) float32, Cb and Cr
    codes of each pixel.
    """
    height, width = luma.shape
    codes = chroma.copy()
    chroma[:] = 0
    runs = _runs(surface.maps[0])
    if not len(runs):
        return
    region = np.zeros((), _REGION)
    region["size"], region["luma_stride"] = (width, height), stride_of(luma)
    region["mean"], region["to_patch"] = surface.mean, surface.to_patch.ravel()
    kernel = device.kernel("paint", coding.transfer, luma.dtype)
    with device.lend(luma, codes, chroma, surface.maps, surface.environment, runs) as buffers:
        arguments = [*buffers, coding_argument(coding), region, material.argument()]
        device.launch(kernel, (len(runs) * LOCAL_SIZE[0], 1), arguments)


def _runs(weight: np.ndarray) -> np.ndarray:
    """(N,) int32: where work-groups begin, y * width + x, that hold any weight; weight is (h, w)."""
    width = weight.shape[1]
    most = np.maximum.reduceat(weight, np.arange(0, width, LOCAL_SIZE[0]), axis=1)
    y, run = np.nonzero(most)
    first: np.ndarray = y * width + run * LOCAL_SIZE[0]
    return first.astype(np.int32)


def paint_twin(
    luma: np.ndarray, chroma: np.ndarray, surface: Surface, material: Material, coding: Coding
) -> tuple[np.ndarray, np.ndarray]:
    """What `paint` does, in float64: the new luma codes, and the change of chroma (2, h, w)."""
    codes = np.stack([luma.astype(np.float64), *chroma.astype(np.float64)], axis=-1)
    weight, coarse, nx, ny = surface.maps.astype(np.float64)
    environment = surface.environment.astype(np.float64)
    skin = skin_at(coarse, surface.mean, nx, ny, environment, material)
    y, x = np.mgrid[: luma.shape[0], : luma.shape[1]].astype(np.float32)
    a, b, c, d, e, f = surface.to_patch.astype(np.float32).ravel()
    light = made_up(
        decode(codes, coding), weight, a * x + b * y + c, d * x + e * y + f, skin, material
    )
    new = np.where(weight[..., None] > 0, encode(light, coding), codes)
    return rounded(new[..., 0], coding).astype(luma.dtype), np.moveaxis(
        (new - codes)[..., 1:], -1, 0
    )
