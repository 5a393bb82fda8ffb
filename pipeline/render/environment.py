"""What a glossy product mirrors: the frame, blurred, less its own average."""

import math
from functools import lru_cache

import cv2
import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.material import ENVIRONMENT_PX, Environment
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.product_material import film_matrices
from makeup_video.pipeline.render.scene import SceneLight

_ROOM_COLOUR = 0.4  # of what is reflected: a close-up's frame is mostly the face itself
_VEIL = 0.7  # of the room's mean light: what a reflection does not show
_NO_ROOM = Environment.of(np.zeros((3, ENVIRONMENT_PX, ENVIRONMENT_PX), np.float32))
_EVEN = np.full(ENVIRONMENT_PX, 1 / ENVIRONMENT_PX, np.float32)


def environment_of(light: SceneLight, params: GraphicsParams, coding: Coding) -> Environment:
    """What the product mirrors, blurred as its parameters say.

    The room's own average is taken off: gloss shows windows and lamps, and an even room would only
    lay a veil over the colour.
    """
    if not params.reflection:
        return _NO_ROOM
    return _mirrored(light, 0.6 + 4 * params.environment_blur, coding.primaries)


@lru_cache(maxsize=16)  # both eyes mirror the same
def _mirrored(light: SceneLight, sigma: float, primaries: int) -> Environment:
    blur = _blur(sigma)
    columns, means = _room_columns(sigma, primaries)
    blurred = blur @ (light.environment.reshape(ENVIRONMENT_PX, -1) @ columns)
    blurred -= (_EVEN @ blurred) @ means
    bright: np.ndarray = np.maximum(blurred, 0, out=blurred)
    return Environment.of(bright.reshape(ENVIRONMENT_PX, 3, ENVIRONMENT_PX).swapaxes(0, 1))


@lru_cache
def _room_columns(sigma: float, primaries: int) -> tuple[np.ndarray, np.ndarray]:
    """Two (48, 48) float32 matrices for a row of 16 texels with three colours each.

    The first blurs each colour, takes some of the saturation and changes to the primaries in which
    products are mixed. The second gives what is subtracted from such a row.
    """
    colours = _ROOM_COLOUR * np.eye(3) + (1 - _ROOM_COLOUR) / 3
    colours = np.reshape(film_matrices(primaries)[0], (3, 3)) @ colours
    columns = np.einsum("ix,jc->xcji", _blur(sigma), colours)
    means = np.kron(np.eye(3), np.full((ENVIRONMENT_PX,) * 2, _VEIL / ENVIRONMENT_PX))
    side = 3 * ENVIRONMENT_PX
    return columns.reshape(side, side).astype(np.float32), means.astype(np.float32)


@lru_cache
def _blur(sigma: float) -> np.ndarray:
    """(16, 16) float32: the matrix that blurs the rows of an environment; the border
    is repeated."""
    rows = np.eye(ENVIRONMENT_PX, dtype=np.float32)
    taps = cv2.getGaussianKernel(2 * math.ceil(4 * sigma) + 1, sigma, cv2.CV_32F)
    border = cv2.BORDER_REPLICATE
    return cv2.sepFilter2D(rows, -1, np.ones(1, np.float32), taps, borderType=border)
