"""Runs one net on one crop, outside training. The whole chain is in pipeline/faces/nets.py."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import onnxruntime
from makeup_video.training.faces.crops import CropSpec

# (N, H, W, 3) uint8 -> outputs
Net = Callable[[np.ndarray], tuple[np.ndarray, ...]]


def crop_to_px(pose: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """The map (2, 3) from the net's IOD offsets to image px. pose: (2, 3)."""
    return np.column_stack([pose[:, :2], pose[:, :2] @ centre + pose[:, 2]])


def take(rgb8: np.ndarray, to_image: np.ndarray, spec: CropSpec, flip: bool = False) -> np.ndarray:
    """The crop under a map from IOD to image px, averaged where the crop shrinks the image.

    flip: mirror the crop.
    """
    w, h = spec.size_wh
    unit = spec.span / w  # IOD per crop px
    side = np.diag([-unit if flip else unit, unit])
    middle = side @ [-(w - 1) / 2, -(h - 1) / 2]
    to_px = np.column_stack([to_image[:, :2] @ side, to_image[:, :2] @ middle + to_image[:, 2]])
    step = np.sqrt(abs(np.linalg.det(to_px[:, :2])))
    while step > 2:
        rgb8 = cv2.resize(rgb8, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        to_px = to_px / 2
        to_px[:, 2] -= 0.25
        step /= 2
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(rgb8, to_px, (w, h), flags=flags, borderMode=cv2.BORDER_REPLICATE)


def from_onnx(path: Path, threads: int = 1) -> Net:
    """Loads an exported net, which runs on the given number of threads."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    session = onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    return lambda rgb8: tuple(session.run(None, {"rgb8": rgb8}))


def place(points: np.ndarray, to_image: np.ndarray) -> np.ndarray:
    """Points (K, 3) in IOD from a net -> image px."""
    xy = points[:, :2] @ to_image[:, :2].T + to_image[:, 2]
    scale = np.sqrt(np.linalg.det(to_image[:, :2]))
    return np.column_stack([xy, points[:, 2] * scale]).astype(np.float32)
