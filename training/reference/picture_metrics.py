"""Distances between two pictures of a face. The metrics themselves are from libraries."""

from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.affine import AffineArray
from skimage.color import deltaE_ciede2000, rgb2lab

FACE_PX = 256  # side of the crops that L1, MS-SSIM and LPIPS compare
_ROOM = 1.1  # side of the crop, in longer sides of the box around the face's points
WHOLE = ("L1", "1-MS-SSIM", "LPIPS")
# N pictures and the true one, (256, 256, 3) uint8 -> (N, 3), as WHOLE; NaN where not measured
Whole = Callable[[Sequence[np.ndarray], np.ndarray], np.ndarray]


def ciede2000(a: np.ndarray, b: np.ndarray, where: np.ndarray) -> float:
    """Mean CIEDE2000 over some px of two pictures (H, W, 3) uint8, sRGB-encoded."""
    return float(deltaE_ciede2000(rgb2lab(a[where]), rgb2lab(b[where])).mean())


def face_crop_to_px(face: Face) -> AffineArray:
    """The map of a square crop around the face: px of the 256 px crop -> px of the picture."""
    low, high = face.points_px[:, :2].min(0), face.points_px[:, :2].max(0)
    step = float((high - low).max()) * _ROOM / FACE_PX
    corner = (low + high) / 2 - step * (FACE_PX - 1) / 2
    return np.array([[step, 0, corner[0]], [0, step, corner[1]]])


def crop_face(rgb8: np.ndarray, to_px: AffineArray) -> np.ndarray:
    """The crop (256, 256, 3) uint8 under a map; beyond the picture its border is repeated."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size_wh = FACE_PX, FACE_PX
    return cv2.warpAffine(rgb8, to_px, size_wh, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def whole_scores(lpips_weights: Sequence[Path] = ()) -> Whole:
    """A function that measures L1 and 1-MS-SSIM of values in 0..1, and LPIPS if given weights."""
    import torch
    from makeup_video.training.reference import lpips
    from pytorch_msssim import ms_ssim

    net = lpips.load(lpips_weights) if lpips_weights else None

    def score(pictures: Sequence[np.ndarray], truth: np.ndarray) -> np.ndarray:
        stack = np.stack([*pictures, truth]).astype(np.float32) / 255
        x = torch.from_numpy(stack).permute(0, 3, 1, 2)
        x, wanted = x[:-1], x[-1:].expand(len(pictures), -1, -1, -1).contiguous()
        alike = ms_ssim(x, wanted, data_range=1.0, size_average=False)
        perceived = net(x, wanted) if net else torch.full((len(x),), torch.nan)
        return torch.stack([(x - wanted).abs().mean((1, 2, 3)), 1 - alike, perceived], 1).numpy()

    return score
