"""Where the crops of a face lie that the nets read.

Points are complex numbers, x + iy, in upright px of a Picture.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from makeup_video.pipeline.faces.face import PATCH_SPAN
from makeup_video.pipeline.faces.similarity import Similarity, iod_of
from makeup_video.pipeline.frames.affine import AffineArray


@dataclass(frozen=True, slots=True)
class NetInput:
    """The crop that a net reads."""

    size_wh: tuple[int, int]  # px
    span: float  # width of the crop in IOD

    def to_px(self, pose: Similarity, centre: complex, mirrored: bool = False) -> list[list[float]]:
        """(2, 3), crop px -> upright px: turned and scaled as the pose, its middle at centre."""
        turn = pose.turn * (self.span / self.size_wh[0])
        across = -turn if mirrored else turn
        x, y = (self.size_wh[0] - 1) / 2, (self.size_wh[1] - 1) / 2
        corner = centre - across * x - turn * complex(0, y)
        return [
            [across.real, -turn.imag, corner.real],
            [across.imag, turn.real, corner.imag],
        ]


MESH_CROP = NetInput((96, 96), 2.56)
LIP_CROP = NetInput((112, 80), PATCH_SPAN)
EYE_CROP = NetInput((64, 48), 0.72)
# The crop of the lips is PATCH_SPAN wide, or for a wide or open mouth up to half as wide again;
# while a face is followed, in steps, so that it stays the same while a mouth hardly changes.
_SPAN_STEP, _MOST_STEPS = 1.1, 4
_AROUND_LIPS = 1.12  # width and height of the crop in those of the lips

_LAYOUT_STEPS = 64  # to an IOD, at least: of the grid on which layouts lie
_KEPT = 0.15  # of a step; more would let two runs keep different layouts for longer
_SAME_IOD = 0.005  # a share: within it, two measurements of a still face differ


class CropLayout(NamedTuple):
    """Where the crops of a face lie, in upright px.

    pose: turn and scale of all crops. centres: of the crops of the lips, the left and the right
    eye. widening: of the crop of the lips, in steps above its least width.
    """

    pose: Similarity
    centres: tuple[complex, complex, complex]
    widening: float = 0.0

    @property
    def lip_span(self) -> float:
        """The width of the crop of the lips, in IOD."""
        return float(PATCH_SPAN * _SPAN_STEP**self.widening)

    def rounded(self, before: "CropLayout | None" = None) -> "CropLayout":
        """This layout on a grid, whose step is a power of two and about 1/64 IOD at most.

        Two runs that follow a face from different frames on differ by less. From one grid, the nets
        read the same numbers, and the runs no longer differ. A number of the layout `before` is
        kept while the new one lies at most _KEPT steps nearer to the next, and so is its grid where
        the IOD may mean either of two: between them, noise would decide.
        """
        now = (*self.pose, *self.centres)
        kept = now if before is None else (*before.pose, *before.centres)
        old_widening = self.widening if before is None else before.widening
        iod = iod_of(self.pose)
        step = _step(iod * (1 + _SAME_IOD))
        if not all(number.real % step == 0 == number.imag % step for number in kept):
            step = _step(iod * (1 - _SAME_IOD))
        turn, shift, *centres = (
            complex(_snap(new.real, old.real, step), _snap(new.imag, old.imag, step))
            for new, old in zip(now, kept, strict=True)
        )
        lips, left, right = centres
        widening = _snap(self.widening, old_widening, 1)
        return CropLayout(Similarity(turn, shift), (lips, left, right), widening)


def _step(iod: float) -> float:
    """The largest power of two of at most 1/64 IOD."""
    return 2.0 ** math.floor(math.log2(max(iod, 1.0) / _LAYOUT_STEPS))


def _snap(new: float, old: float, step: float) -> float:
    """The multiple of step that is nearest to `new`; `old`, a multiple, while that is as near."""
    is_kept = old % step == 0 and abs(new - old) < (0.5 + _KEPT) * step
    return old if is_kept else round(new / step) * step


def eye_crops(layout: CropLayout) -> tuple[np.ndarray, tuple[int, int]]:
    """The maps (2, 2, 3), crop px -> upright px, of both eyes; the right one is mirrored."""
    pose, centres = layout.pose, layout.centres
    to_px = [EYE_CROP.to_px(pose, centres[1 + side], bool(side)) for side in (0, 1)]
    return np.array(to_px), EYE_CROP.size_wh


def lips_widening(lips: np.ndarray, pose: Similarity) -> float:
    """The steps above its least width by which the crop of lips (80,) must be wider."""
    share = _AROUND_LIPS * _reach(lips - lips.mean(), pose, PATCH_SPAN)
    return min(math.log(max(share, 1)) / math.log(_SPAN_STEP), _MOST_STEPS)


def lips_reach(lips: np.ndarray, layout: CropLayout) -> float:
    """How far lips (80,) reach from the middle of their crop; 1 is its border."""
    return _reach(lips - layout.centres[0], layout.pose, layout.lip_span)


def _reach(off: np.ndarray, pose: Similarity, span: float) -> float:
    """The furthest of points (N,), from the middle of a crop of the lips that is `span` IOD wide,
    in halves of its width and height."""
    upright = off / (pose.turn or 1)
    wide, high = LIP_CROP.size_wh
    across, down = np.abs(upright.real).max(), np.abs(upright.imag).max() * wide / high
    return 2 * float(max(across, down)) / span


def lip_patch_to_px(layout: CropLayout) -> AffineArray:
    """(2, 3), px of the lip patch -> upright px."""
    crop = NetInput(LIP_CROP.size_wh, layout.lip_span)
    return np.array(crop.to_px(layout.pose, layout.centres[0]))
