"""How a face moved between two frames, measured on its luma: cheaper than reading it anew.

Dense inverse search (Kroeger et al., "Fast Optical Flow using Dense Inverse Search", ECCV 2016) on a small
upright crop, for a sixth of the work of the nets; docs/live.md tells how much is lost.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from makeup_video.pipeline.faces.similarity import Similarity, middle_of
from makeup_video.pipeline.frames.affine import AffineArray, compose, invert
from makeup_video.pipeline.frames.sampling import eight_bits, pixel_places, sample
from makeup_video.pipeline.frames.views import FramePicture

_SIDE = 80  # px of the crop; with 64 blinks are followed worse, with 128 nothing is
_SPAN = 1.6  # IOD: lips, eyes and all that is painted
_SIZE = (_SIDE, _SIDE)
_FINEST = 1  # the scale of halves at which the search ends; at 0 it takes four times as long
_ROWS, _COLUMNS = np.mgrid[:_SIDE, :_SIDE].astype(np.float32)
# Correlation of what was seen with what is seen now, moved back. When it is less, something else is
# there: a hand, or teeth in a mouth that opens.
_ALIKE, _MOUTH_ALIKE = 0.98, 0.965
# IOD, the standard deviation of the motion down around the mouth. One that opens or shuts fast is
# measured too small, and lipstick would lie on the skin beside it.
_MOUTH_STRETCHES = 0.01
_MOUTH = np.s_[round(0.55 * _SIDE) : round(0.95 * _SIDE), round(0.2 * _SIDE) : round(0.8 * _SIDE)]
_FURTHEST = 0.1  # of the crop's side: beyond, the search finds what it wants


@dataclass(frozen=True, slots=True, eq=False)
class Still:
    """A face's luma at one moment. luma8: (80, 80) uint8. to_px: (2, 3), its px to upright px."""

    luma8: np.ndarray
    to_px: AffineArray


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """From one moment to another. flow: (80, 80, 2) float32, px of the crops."""

    before: Still
    now: Still
    flow: np.ndarray

    def of(self, xy: np.ndarray) -> np.ndarray:
        """(K,) complex, upright px, before -> where they are now."""
        at = invert(self.before.to_px) @ np.stack([xy.real, xy.imag, np.ones(len(xy))])
        x, y = at.astype(np.float32)[:, None]
        at += self._flow_at(x, y)[0].T
        real, imag = self.now.to_px[:, :2] @ at + self.now.to_px[:, 2:]
        there: np.ndarray = real + 1j * imag
        return there

    def carried(self, patch: np.ndarray, to_px: AffineArray, to_px_now: AffineArray) -> np.ndarray:
        """(H, W) float32 that lay at to_px before, as it lies at to_px_now: its own px to upright px."""
        high, wide = patch.shape
        to_crop = compose(invert(self.before.to_px), to_px)
        flow = cv2.warpAffine(
            self.flow, to_crop, (wide, high), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        # Each px of the patch is led to where it is now, (x, y); and whoever is there came from about
        # as far to the other side, for flow is smooth.
        now_to_patch = compose(invert(to_px_now), self.now.to_px)
        places = pixel_places((wide, high))
        there = compose(now_to_patch, to_crop).astype(np.float32) @ places
        there += now_to_patch[:, :2].astype(np.float32) @ flow.reshape(-1, 2).T
        from_x, from_y = (2 * places[:2] - there).reshape(2, high, wide)
        return cv2.remap(patch, from_x, from_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)

    def _flow_at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return cv2.remap(self.flow, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


class MeasureMotion:
    """Keeps the memory of the search; not for several threads at once."""

    def __init__(self) -> None:
        self._search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)
        self._search.setFinestScale(_FINEST)
        self._search.setPatchSize(8)
        self._search.setPatchStride(4)
        self._search.setGradientDescentIterations(12)

    def still(self, picture: FramePicture, frame: Similarity) -> Still:
        """What is seen of a face now: a copy, for the frame will be painted."""
        turn = frame.turn * (_SPAN / _SIDE)
        corner = middle_of(frame) - turn * complex(_SIDE - 1, _SIDE - 1) / 2
        to_px = np.array(
            [[turn.real, -turn.imag, corner.real], [turn.imag, turn.real, corner.imag]]
        )
        luma = sample(picture.frame.planes[0], compose(picture.to_stored, to_px), _SIZE)
        return Still(eight_bits(luma, picture.frame), to_px)

    def __call__(self, before: Still, now: Still) -> Motion | None:
        """None when the two do not show the same, or too much moved."""
        start = np.zeros((*_SIZE, 2), np.float32)  # the second crop lies where the face is expected
        flow = np.asarray(self._search.calc(before.luma8, now.luma8, start), np.float32)
        if not np.abs(flow).max() < _FURTHEST * _SIDE:
            return None
        back = cv2.remap(
            now.luma8, _COLUMNS + flow[..., 0], _ROWS + flow[..., 1], cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        is_sure = (
            flow[_MOUTH][..., 1].std() < _MOUTH_STRETCHES * _SIDE / _SPAN
            and _likeness(back, before.luma8) > _ALIKE
            and _likeness(back[_MOUTH], before.luma8[_MOUTH]) > _MOUTH_ALIKE
        )
        return Motion(before, now, flow) if is_sure else None


def _likeness(a: np.ndarray, b: np.ndarray) -> float:
    """Their correlation, -1 to 1; that of an even picture is 1."""
    return float(cv2.matchTemplate(a, b, cv2.TM_CCOEFF_NORMED)[0, 0])
