"""Host side of product.cl, which turns products and the light on them into what paint.cl paints.

Its numpy twins are in pipeline/render/product_twin.py.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from makeup_video.kernels.colour import SRGB
from makeup_video.kernels.definitions import Definitions, offsets
from makeup_video.kernels.material import ENVIRONMENT_PX, FAINTEST_STEP
from makeup_video.kernels.paint import DEFINITIONS as PAINT
from makeup_video.kernels.paint import LAYERS, PRODUCT
from makeup_video.kernels.program import Device

# Sparkles. Sizes of their cells and radii: `_cells` of product_twin.py explains them.
LEAST_CELL_PX = 4.0  # codecs remove smaller sparkles, or they look like grains of salt
DISSOLVE = 0.15  # of the least cell: the sizes over which one grid of cells gives way to another
SPOT, LEAST_SPOT_PX, LARGEST_SPOT = 0.28, 1.2, 0.3  # radius: in cells, least in px, most in cells
DARK = 0.004  # of diffuse white: a fifth of a code of 8 bits counts for little below this
NONE = 1e-6  # coats that show less than this have no colour of their own
VEIL = 0.7  # share of the room's mean light that a reflection does not show

# The structs of product.cl.
# What neither light nor place changes of a coat; colours are linear, in sRGB's primaries.
COAT = np.dtype([
    ("strength", np.float32),  # factor of opacity, glint, sheen, sparkle, highlights, reflection
    ("adaptation", np.float32),  # how far the product takes the light's colour and strength
    ("product", np.float32, 3),
    ("glint", np.float32, 3),  # of the synthetic highlight, and of sparkles too fine to be seen
    ("sheen", np.float32, 3),
    ("sparkle", np.float32, 3),
    ("opacity", np.float32),
    ("texture", np.float32),
    ("undertone", np.float32),
    ("keep_highlights", np.float32),
    ("own_highlights", np.float32),
    ("lobe", np.float32),
    ("reflection", np.float32),
    ("fresnel_front", np.float32),
    ("fresnel_rim", np.float32),
    ("room", np.float32),  # texels of the environment for a unit of a reflected ray
    ("shimmer", np.float32),
    ("cell", np.float32),  # the smallest size of a sparkle's cell, in the eyes' distance
    ("most_doublings", np.int32),  # of that size, on small faces
    ("dark_gain", np.float32),
    ("dark_offset", np.float32),
    ("blur", np.float32, (ENVIRONMENT_PX, ENVIRONMENT_PX)),  # a row of texels @ blur is blurred
])  # fmt: skip
REGION = np.dtype([
    ("to_px", np.float32, 6),  # px of the grid -> px of the rectangle
    ("skin_px", np.float32),  # px for the eyes' distance
    ("amount", np.float32),  # factor of each coat's strength
    ("strength", np.float32),  # of the light on the region
    ("colour", np.float32, 3),
    ("direction", np.float32, 3),
    ("seen", np.float32, LAYERS),  # how much each coat shows; for several coats only
    ("coat_count", np.int32),
    ("coats", COAT, LAYERS),
])  # fmt: skip
CODING = np.dtype([
    ("luminance", np.float32, 3),
    ("to_film", np.float32, 9),
    ("from_film", np.float32, 9),
    ("to_room", np.float32, 9),  # from the frame's primaries to the colours of what is mirrored
    ("ceiling", np.float32),
])  # fmt: skip
_HEAD_SIZE = offsets(REGION)["COAT_COUNT_AT"]  # floats before it
_COATS_AT = offsets(REGION)["COATS_AT"]
_ROOM = ENVIRONMENT_PX**2  # words of an environment
_UNSEEN = (0.0,) * LAYERS
DEFINITIONS = PAINT + Definitions(
    {
        "PRODUCT_LEAST_CELL_PX": LEAST_CELL_PX,
        "PRODUCT_DISSOLVE": DISSOLVE,
        "PRODUCT_SPOT": SPOT,
        "PRODUCT_LEAST_SPOT_PX": LEAST_SPOT_PX,
        "PRODUCT_LARGEST_SPOT": LARGEST_SPOT,
        "PRODUCT_DARK": DARK,
        "PRODUCT_NONE": NONE,
        "PRODUCT_VEIL": VEIL,
        "PRODUCT_FAINTEST_STEP": FAINTEST_STEP,
    },
    {
        "product_coat": COAT,
        "product_region": REGION,
        "product_coding": CODING,
    },
)


class LitRegion(NamedTuple):
    """Products on a region, and the light there.

    to_px: (2, 3) by rows, px of the grid -> px of the region's rectangle.
    skin_px: px of the picture for one unit of the coordinates that stick to the skin.
    coats: (N,) records of COAT, N from 1 to LAYERS, in the order of painting.  amount: factor of
    their strength.
    strength, colour, direction, room: see SceneLight; the strength is that on the region.
    seen: how much each coat shows on the region; for several coats only.
    """

    to_px: Sequence[float]
    skin_px: float
    coats: np.ndarray
    amount: float
    strength: float
    colour: np.ndarray
    direction: np.ndarray
    room: np.ndarray
    seen: Sequence[float] = ()


class ProductKernel:
    """Runs the kernel for a few regions at a time, on a device that no other thread uses.

    Its memory is kept, so that the kernel keeps its arguments.
    """

    def __init__(self, device: Device) -> None:
        self._device = device
        self._coding = device.memory((1,), CODING)
        self._given_coding: np.ndarray | None = None
        self._kernel = device.kernel("product", SRGB, np.dtype(np.uint8), DEFINITIONS)
        self._make_room(8)

    def _make_room(self, count: int) -> None:
        memory = self._device.memory
        self._regions = memory((count,), REGION)
        self._rooms = memory((count, ENVIRONMENT_PX, ENVIRONMENT_PX, 3), np.float32)
        self._products, self._words = memory((count,), PRODUCT), memory((count, _ROOM), np.int32)
        self._words.array.fill(0)
        numbers = self._regions.array.view(np.float32).reshape(count, -1)
        self._heads, self._coats = numbers[:, :_HEAD_SIZE], numbers[:, _COATS_AT:]
        self._counts = self._regions.array["coat_count"]
        used = self._regions, self._rooms, self._coding, self._products, self._words
        self._kernel.set_args(*(memory.buffer for memory in used))

    def __call__(
        self, regions: Sequence[LitRegion], coding: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Make the products of regions.

        Returns (N,) records of PRODUCT, and (N, 256) words of their environments, all valid until
        the next call.  coding: a record of CODING.  It must not change afterwards.
        """
        if len(regions) > len(self._regions.array):
            self._make_room(2 * len(regions))
        if coding is not self._given_coding:
            self._coding.array[0] = self._given_coding = coding
        self._heads[: len(regions)] = [
            (
                *region.to_px, region.skin_px, region.amount, region.strength, *region.colour,
                *region.direction, *region.seen, *_UNSEEN[len(region.seen) :],
            )
            for region in regions
        ]  # fmt: skip
        for number, region in enumerate(regions):
            self._counts[number] = len(region.coats)
            coats = region.coats.view(np.float32)  # copied many times as quickly as records
            self._coats[number, : len(coats)] = coats
            self._rooms.array[number] = region.room
        for memory in (self._regions, self._rooms, self._coding):
            memory.send()
        self._device.launch(self._kernel, (len(regions), 1), (), (1, 1))
        self._products.fetch()
        self._words.fetch()
        self._device.finish()
        return self._products.array, self._words.array
