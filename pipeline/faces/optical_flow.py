"""Measures how a face moved between two frames from its luma: cheaper than running the nets again.

Dense inverse search (Kroeger et al., "Fast Optical Flow using Dense Inverse Search", ECCV 2016) on
a small upright crop takes a sixth of the work of the nets; docs/live.md says what is lost.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from makeup_video.pipeline.faces.similarity import Similarity, middle_of
from makeup_video.pipeline.frames.affine import AffineArray, compose, invert
from makeup_video.pipeline.frames.sampling import eight_bits, pixel_places, sample
from makeup_video.pipeline.frames.views import FramePicture

_SIDE = 80  # px of the crop; 64 px follow blinks worse, 128 px follow nothing better
_SPAN = 1.6  # width of the crop in IOD: lips, eyes and everything that is painted
_SIZE = (_SIDE, _SIDE)
# The pyramid level at which the search ends; down to level 0 it takes four times as long.
_FINEST = 1
_ROWS, _COLUMNS = np.mgrid[:_SIDE, :_SIDE].astype(np.float32)
# Least correlation of the old crop with the new one, moved back. Below it, the crop shows something
# else: a hand, or teeth in a mouth that opens.
_ALIKE, _MOUTH_ALIKE = 0.98, 0.965
# Limit of the standard deviation of the vertical motion around the mouth, in IOD. When a mouth
# opens or shuts fast, the flow measures too little motion, and lipstick would lie on the skin
# beside it.
_MOUTH_STRETCHES = 0.01
_MOUTH = np.s_[round(0.55 * _SIDE) : round(0.95 * _SIDE), round(0.2 * _SIDE) : round(0.8 * _SIDE)]
_FURTHEST = 0.1  # of the crop's side: longer flow is not reliable


@dataclass(frozen=True, slots=True, eq=False)
class LumaCrop:
    """The luma of a face at one moment.

    luma8: (80, 80) uint8. to_px: (2, 3), crop px -> upright px.
    """

    luma8: np.ndarray
    to_px: AffineArray


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """The motion of a face from one moment to another.

    flow: (80, 80, 2) float32, px of the crops.
    """

    before: LumaCrop
    now: LumaCrop
    flow: np.ndarray

    def move(self, xy: np.ndarray) -> np.ndarray:
        """Where points (K,) complex128, upright px, are now."""
        in_crop = invert(self.before.to_px) @ np.stack([xy.real, xy.imag, np.ones(len(xy))])
        x, y = in_crop.astype(np.float32)[:, None]
        in_crop += self._flow_at(x, y)[0].T
        real, imag = self.now.to_px[:, :2] @ in_crop + self.now.to_px[:, 2:]
        moved: np.ndarray = real + 1j * imag
        return moved

    def move_patch(
        self, patch: np.ndarray, to_px: AffineArray, now_to_px: AffineArray
    ) -> np.ndarray:
        """The patch as it appears now, (H, W) float32.

        patch: (H, W) float32, before. to_px, now_to_px: patch px -> upright px, before and now.
        """
        high, wide = patch.shape
        to_crop = compose(invert(self.before.to_px), to_px)
        flow = cv2.warpAffine(
            self.flow, to_crop, (wide, high), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        # The flow leads each pixel of the patch to where it is now. The flow is smooth, so what
        # lies at a pixel now came from about as far on the opposite side.
        now_to_patch = compose(invert(now_to_px), self.now.to_px)
        places = pixel_places((wide, high))
        moved = compose(now_to_patch, to_crop).astype(np.float32) @ places
        moved += now_to_patch[:, :2].astype(np.float32) @ flow.reshape(-1, 2).T
        from_x, from_y = (2 * places[:2] - moved).reshape(2, high, wide)
        return cv2.remap(patch, from_x, from_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)

    def _flow_at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return cv2.remap(self.flow, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


class MeasureMotion:
    """Two crops of a face -> Motion. Keeps the search's buffers, so each thread needs its own."""

    def __init__(self) -> None:
        self._search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)
        self._search.setFinestScale(_FINEST)
        self._search.setPatchSize(8)
        self._search.setPatchStride(4)
        self._search.setGradientDescentIterations(12)

    def crop(self, picture: FramePicture, pose: Similarity) -> LumaCrop:
        """The luma of a face now: a copy, because the frame will be painted."""
        turn = pose.turn * (_SPAN / _SIDE)
        corner = middle_of(pose) - turn * complex(_SIDE - 1, _SIDE - 1) / 2
        to_px = Similarity(turn, corner).array()
        luma = sample(picture.frame.planes[0], compose(picture.to_stored, to_px), _SIZE)
        return LumaCrop(eight_bits(luma, picture.frame), to_px)

    def __call__(self, before: LumaCrop, now: LumaCrop) -> Motion | None:
        """None when the two crops do not show the same thing, or when too much moved."""
        start = np.zeros((*_SIZE, 2), np.float32)  # `now` lies where the face is expected
        flow = np.asarray(self._search.calc(before.luma8, now.luma8, start), np.float32)
        if not np.abs(flow).max() < _FURTHEST * _SIDE:
            return None
        back = cv2.remap(
            now.luma8, _COLUMNS + flow[..., 0], _ROWS + flow[..., 1], cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        is_sure = (
            flow[_MOUTH][..., 1].std() < _MOUTH_STRETCHES * _SIDE / _SPAN
            and _correlation(back, before.luma8) > _ALIKE
            and _correlation(back[_MOUTH], before.luma8[_MOUTH]) > _MOUTH_ALIKE
        )
        return Motion(before, now, flow) if is_sure else None


def _correlation(a: np.ndarray, b: np.ndarray) -> float:
    """The correlation of two pictures, -1 to 1; 1 for a flat picture."""
    return float(cv2.matchTemplate(a, b, cv2.TM_CCOEFF_NORMED)[0, 0])
