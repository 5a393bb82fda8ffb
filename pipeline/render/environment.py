"""How a glossy product mirrors the frame around it, which kernels/product.cl computes."""

import math
from functools import lru_cache

import cv2
import numpy as np
from makeup_video.kernels.material import ENVIRONMENT_PX
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.product_material import film_matrices

_ROOM_COLOUR = 0.4  # saturation that a reflection keeps: a close-up is mostly the face itself


@lru_cache
def room_colours(primaries: int) -> np.ndarray:
    """(3, 3): the matrix that removes some of the saturation, and changes to the primaries in which
    products are mixed."""
    colours = _ROOM_COLOUR * np.eye(3) + (1 - _ROOM_COLOUR) / 3
    turned: np.ndarray = np.reshape(film_matrices(primaries)[0], (3, 3)) @ colours
    return turned


def blur_matrix(params: GraphicsParams) -> np.ndarray:
    """(16, 16) float32: the matrix that blurs a column of an environment; the border is
    repeated."""
    return _blur(0.6 + 4 * params.environment_blur)


@lru_cache
def _blur(sigma: float) -> np.ndarray:
    rows = np.eye(ENVIRONMENT_PX, dtype=np.float32)
    taps = cv2.getGaussianKernel(2 * math.ceil(4 * sigma) + 1, sigma, cv2.CV_32F)
    border = cv2.BORDER_REPLICATE
    return cv2.sepFilter2D(rows, -1, np.ones(1, np.float32), taps, borderType=border)
