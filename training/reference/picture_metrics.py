"""How far two pictures of a face are from each other. The measures themselves are libraries'."""

from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.affine import AffineArray
from skimage.color import deltaE_ciede2000, rgb2lab

FACE_PX = 256  # side of what L1, MS-SSIM and LPIPS see
_ROOM = 1.1  # side by the longer side of the points' box
WHOLE = ("L1", "1-MS-SSIM", "LPIPS")
# (N, 256, 256, 3) uint8 of pictures, one of the truth -> (N,) each of WHOLE; NaN where not measured
Whole = Callable[[Sequence[np.ndarray], np.ndarray], np.ndarray]


def ciede2000(a: np.ndarray, b: np.ndarray, where: np.ndarray) -> float:
    """Mean over some px of two (H, W, 3) uint8 pictures, sRGB-encoded."""
    return float(deltaE_ciede2000(rgb2lab(a[where]), rgb2lab(b[where])).mean())


def face_window(face: Face) -> AffineArray:
    """A square around the face: px of a picture of 256 px -> px of its picture."""
    low, high = face.points_px[:, :2].min(0), face.points_px[:, :2].max(0)
    step = float((high - low).max()) * _ROOM / FACE_PX
    corner = (low + high) / 2 - step * (FACE_PX - 1) / 2
    return np.array([[step, 0, corner[0]], [0, step, corner[1]]])


def face_of(rgb8: np.ndarray, window: AffineArray) -> np.ndarray:
    """(256, 256, 3) uint8 that a window shows; what lies outside the picture repeats its border."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size_wh = FACE_PX, FACE_PX
    return cv2.warpAffine(rgb8, window, size_wh, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def whole_scores(lpips_weights: Sequence[Path] = ()) -> Whole:
    """L1 and 1-MS-SSIM of values in 0..1, and LPIPS where its weights are given."""
    import torch
    from makeup_video.training.reference import lpips
    from pytorch_msssim import ms_ssim

    net = lpips.load(lpips_weights) if lpips_weights else None

    def score(pictures: Sequence[np.ndarray], truth: np.ndarray) -> np.ndarray:
        stack = np.stack([*pictures, truth]).astype(np.float32) / 255
        x = torch.from_numpy(stack).permute(0, 3, 1, 2)
        x, wanted = x[:-1], x[-1:].expand(len(pictures), -1, -1, -1).contiguous()
        alike = ms_ssim(x, wanted, data_range=1.0, size_average=False)
        seen = net(x, wanted) if net else torch.full((len(x),), torch.nan)
        return torch.stack([(x - wanted).abs().mean((1, 2, 3)), 1 - alike, seen], 1).numpy()

    return score
