"""What the surfaces of both eyes of a face have in common."""

from collections.abc import Callable, Sequence
from functools import cache, cached_property, partial

import numpy as np
from makeup_video.kernels.shares import CHART_ROWS, EyesToLay
from makeup_video.kernels.surface import LID_HW, LID_LEFT, LID_STEP
from makeup_video.pipeline.look.kinds.fields import LID, LID_RISE_AT, EyeFields
from makeup_video.pipeline.render.surfaces.unfolded import step_of

SIZE_WH = LID_HW[::-1]
TOP = -0.99  # the first row of the grid, in widths of the eye
COLUMNS = np.arange(SIZE_WH[0])
OUTWARDS = LID_LEFT + LID_STEP * COLUMNS
ACROSS = (OUTWARDS + 0.5).astype(np.float32)
_AT_LID_RISE = round((LID_RISE_AT - 0.5 - LID_LEFT) / LID_STEP)
_RISE = (-TOP - LID_STEP * np.arange(SIZE_WH[1])[:, None]).astype(np.float32)


class BothEyes:
    """Heights and distances around both eyes of a face, (2, 32, 48) each, for kinds of makeup."""

    def __init__(
        self,
        up: np.ndarray,
        lash_px: np.ndarray,
        below_px: np.ndarray,
        widths_px: Sequence[float],
        on_face: Callable[[], list[np.ndarray | None]],
    ) -> None:
        """up, lash_px, below_px: see LidSurface.
        widths_px: of the eyes; 1 for an eye that is not seen, so that nothing divides by 0.
        on_face: makes `on_face` of each eye, see LidSurface."""
        self._up, self._lash_px, self._below_px = up, lash_px, below_px
        self._widths_px, self._on_face = widths_px, on_face

    @cached_property
    def on_face(self) -> list[np.ndarray | None]:
        return self._on_face()

    @cached_property
    def opened(self) -> list[float]:
        """How far each eye is open, in widths of the eye."""
        ends = slice(None, None, SIZE_WH[1] - 1)  # the sum changes evenly from row to row
        between = self._lash_px[:, ends] + self._below_px[:, ends]
        least_px = between.min((1, 2)).tolist()
        return [-px / width for px, width in zip(least_px, self._widths_px, strict=True)]

    @cached_property
    def steps(self) -> list[int]:
        """How far each lid is unfolded, see unfolded.py."""
        return [step_of(opening) for opening in self.opened]

    @cached_property
    def to_lay(self) -> EyesToLay:
        """Both eyes as kernels/shares.cl takes them."""
        rows_down = [CHART_ROWS / LID / width_px for width_px in self._widths_px]
        fades = [0.5 / LID_STEP / width_px for width_px in self._widths_px]
        heights = self._up, self._lash_px, self._below_px
        return EyesToLay(*heights, rows_down, fades, self.steps)

    @cached_property
    def upper(self) -> EyeFields:
        """The skin above both eyes."""
        return self._fields(is_upper=True)

    @cached_property
    def lower(self) -> EyeFields:
        """The skin below both eyes."""
        return self._fields(is_upper=False)

    def _fields(self, *, is_upper: bool) -> EyeFields:
        wide = np.array(self._widths_px, np.float32)[:, None, None]
        heights = self._up, self._lash_px, self._below_px
        # not a method: this object keeps the fields, which would refer back to it
        lid_rise = partial(_lid_rise, self._lash_px)
        return EyeFields(is_upper, ACROSS, _RISE, heights, wide, lid_rise)

    def on_chart(self, is_upper: bool) -> tuple[np.ndarray, np.ndarray]:
        """See Surface. Places beyond the lash line have the density of the lash line."""
        if is_upper:
            rows: np.ndarray = self._up * np.float32(CHART_ROWS)
        else:
            rows = self._below_px * np.array(self.to_lay.rows_down, np.float32)[:, None, None]
        y = rows.reshape(-1, SIZE_WH[0])
        return _columns(len(y)), y

    def joined(self, upper: np.ndarray, lower: np.ndarray) -> np.ndarray:
        """Join densities above the eyes and below them, (coats, 2, 32, 48) each.

        Each side fades over a step of the grid beyond the middle between the lash lines, so that
        two colours that meet there leave no bare line.
        """
        fades = np.array(self.to_lay.fades, np.float32)[:, None, None]
        beyond = (self._lash_px - self._below_px) * fades
        above: np.ndarray = upper * np.minimum(np.maximum(1 + beyond, 0), 1)
        np.maximum(above, lower * np.minimum(np.maximum(1 - beyond, 0), 1), out=above)
        return above


def _lid_rise(lash_px: np.ndarray) -> np.ndarray:
    """(2, 1, 1): how far the upper lash line rises at LID_RISE_AT, in widths of the eye."""
    rises = []
    for first, second in lash_px[:, :2, _AT_LID_RISE].tolist():
        row = first / max(first - second, 1e-6)  # heights fall evenly from row to row
        rises.append(-TOP - LID_STEP * row)
    return np.array(rises, np.float32)[:, None, None]


@cache
def _columns(rows: int) -> np.ndarray:
    """(rows, W) float32: the column of each place of the grids."""
    return np.tile(COLUMNS.astype(np.float32), (rows, 1))
