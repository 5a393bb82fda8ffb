"""What a glossy product mirrors: the frame, blurred, less its own average. The numpy twin of the
last step of kernels/product.cl."""

import math
from functools import lru_cache

import cv2
import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.material import ENVIRONMENT_PX, Environment
from makeup_video.kernels.product import VEIL
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.product_material import film_matrices

_ROOM_COLOUR = 0.4  # of what is reflected: a close-up's frame is mostly the face itself


def environment_of(room: np.ndarray, params: GraphicsParams, coding: Coding) -> Environment:
    """What the product mirrors, blurred as its parameters say.

    The room's own average is taken off: gloss shows windows and lamps, and an even room would only
    lay a veil over the colour.

    room: (16, 16, 3), see SceneLight.
    """
    if not params.reflection:
        return Environment.of(np.zeros((3, ENVIRONMENT_PX, ENVIRONMENT_PX), np.float32))
    blur = blur_of(params)
    turned = np.moveaxis(room @ room_colours(coding.primaries).T, -1, 0)
    blurred = blur @ turned @ blur.T
    bright = np.maximum(blurred - VEIL * blurred.mean((1, 2), keepdims=True), 0)
    return Environment.of(bright.astype(np.float32))


@lru_cache
def room_colours(primaries: int) -> np.ndarray:
    """(3, 3): takes some of the saturation, and changes to the primaries in which products are
    mixed."""
    colours = _ROOM_COLOUR * np.eye(3) + (1 - _ROOM_COLOUR) / 3
    turned: np.ndarray = np.reshape(film_matrices(primaries)[0], (3, 3)) @ colours
    return turned


def blur_of(params: GraphicsParams) -> np.ndarray:
    """(16, 16) float32: the matrix that blurs a column of an environment; the border is
    repeated."""
    return _blur(0.6 + 4 * params.environment_blur)


@lru_cache
def _blur(sigma: float) -> np.ndarray:
    rows = np.eye(ENVIRONMENT_PX, dtype=np.float32)
    taps = cv2.getGaussianKernel(2 * math.ceil(4 * sigma) + 1, sigma, cv2.CV_32F)
    border = cv2.BORDER_REPLICATE
    return cv2.sepFilter2D(rows, -1, np.ones(1, np.float32), taps, borderType=border)
