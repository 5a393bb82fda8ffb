"""Crops that never change: PyTorch and the shipped nets must give the same results for them."""

import numpy as np
from makeup_video.pipeline.reference.crops import CROPS


def fixed_crops(region: str) -> np.ndarray:
    """(16, H, W, 3) uint8: squares of random colours."""
    rng, (w, h) = np.random.default_rng(0), CROPS[region].input_wh
    coarse = rng.integers(0, 256, (16, h // 16, w // 16, 3))
    return coarse.repeat(16, 1).repeat(16, 2).astype(np.uint8)
