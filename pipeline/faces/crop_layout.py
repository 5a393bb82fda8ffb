"""Where the nets' crops of a face lie in the picture.

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
        """The (2, 3) map crop px -> upright px, turned and scaled like the pose.

        centre: where the middle of the crop lies. mirrored: whether left and right change places.
        """
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
# The lip crop is PATCH_SPAN wide, and for a wide or open mouth up to half as wide again. While a
# face is followed, the width changes in steps, so that it stays the same while the mouth hardly
# changes.
_SPAN_STEP, _MOST_STEPS = 1.1, 4
_AROUND_LIPS = 1.12  # least size of the lip crop, as a multiple of the lips' size

_LAYOUT_STEPS = 64  # least number of steps per IOD, of the grid that layouts are rounded to
# A number keeps its grid point until it lies this part of a step beyond the midpoint to the next
# one. With more, two runs would keep different layouts for longer.
_KEPT = 0.15
_SAME_IOD = 0.005  # relative difference between two measurements of a still face's IOD


class CropLayout(NamedTuple):
    """Where the crops of a face lie, in upright px.

    pose: gives all crops their turn and scale. centres: of the lip crop, the left eye's crop and
    the right eye's crop. widening: by how many steps the lip crop exceeds its least width.
    """

    pose: Similarity
    centres: tuple[complex, complex, complex]
    widening: float = 0.0

    @property
    def lip_span(self) -> float:
        """The width of the lip crop, in IOD."""
        return float(PATCH_SPAN * _SPAN_STEP**self.widening)

    def rounded(self, before: "CropLayout | None" = None) -> "CropLayout":
        """This layout rounded to a grid, whose step is a power of two and about 1/64 IOD at most.

        Two runs that start to follow a face at different frames differ by less than a step. On the
        grid their crops are the same, so the nets read the same numbers and the runs agree again.

        A number of the layout `before` is kept until the new number lies _KEPT steps beyond the
        midpoint to the next grid point. The grid of `before` is kept when the measured IOD fits
        either of two grids. Otherwise noise would decide.
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
    """The largest power of two that is at most 1/64 of the IOD."""
    return 2.0 ** math.floor(math.log2(max(iod, 1.0) / _LAYOUT_STEPS))


def _snap(new: float, old: float, step: float) -> float:
    """The multiple of step nearest to `new`, or `old` if it is a multiple and nearly as near."""
    is_kept = old % step == 0 and abs(new - old) < (0.5 + _KEPT) * step
    return old if is_kept else round(new / step) * step


def eye_crops(layout: CropLayout) -> tuple[np.ndarray, tuple[int, int]]:
    """The maps of both eyes' crops, (2, 2, 3), crop px -> upright px, and the size of a crop.

    The right eye's crop is mirrored.
    """
    pose, centres = layout.pose, layout.centres
    to_px = [EYE_CROP.to_px(pose, centres[1 + side], bool(side)) for side in (0, 1)]
    return np.array(to_px), EYE_CROP.size_wh


def lips_widening(lips: np.ndarray, pose: Similarity) -> float:
    """By how many steps the crop of lips (80,) must exceed its least width, 0 to _MOST_STEPS."""
    share = _AROUND_LIPS * _reach(lips - lips.mean(), pose, PATCH_SPAN)
    return min(math.log(max(share, 1)) / math.log(_SPAN_STEP), _MOST_STEPS)


def lips_reach(lips: np.ndarray, layout: CropLayout) -> float:
    """How far lips (80,) reach from the middle of their crop; 1 is its border."""
    return _reach(lips - layout.centres[0], layout.pose, layout.lip_span)


def _reach(off: np.ndarray, pose: Similarity, span: float) -> float:
    """How far the furthest point reaches from the middle of a lip crop; 1 is the crop's border.

    off: (N,) px from the middle. span: width of the crop in IOD.
    """
    upright = off / (pose.turn or 1)
    wide, high = LIP_CROP.size_wh
    across, down = np.abs(upright.real).max(), np.abs(upright.imag).max() * wide / high
    return 2 * float(max(across, down)) / span


def lip_patch_to_px(layout: CropLayout) -> AffineArray:
    """(2, 3), px of the lip patch -> upright px."""
    crop = NetInput(LIP_CROP.size_wh, layout.lip_span)
    return np.array(crop.to_px(layout.pose, layout.centres[0]))
