"""Lays the skin around both eyes flat: every place between lashes, crease and brow has its cell.

A column is a place across the eye, as on the eyes' surface. A row is a height: the first ones lie
above the upper lash line, in heights of look/kinds/fields.py, the others below the lower one. So
the maps of different faces may be compared cell by cell, and a shape of eye-shadow covers the same
cells of every face.
"""

from functools import lru_cache

import cv2
import numpy as np
from makeup_video.kernels.surface import LID_LEFT, LID_STEP
from makeup_video.pipeline.frames.sampling import remap
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.fields import LID, EyeFields
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.neutral_face import NeutralFace
from makeup_video.pipeline.render.surfaces.eyes import SIZE_WH, LidSurface
from makeup_video.pipeline.render.surfaces.eyes_reference import lid_surfaces

_UP = np.linspace(2.1, 0.06, 18, dtype=np.float32)
_DOWN = np.linspace(-0.08, -1.3, 9, dtype=np.float32)
HEIGHTS = np.concatenate([_UP, _DOWN])
FLAT_HW = len(HEIGHTS), SIZE_WH[0]
_ACROSS = (LID_LEFT + LID_STEP * np.arange(SIZE_WH[0]) + 0.5).astype(np.float32)
_BLUR_PX = 0.9  # of the neutral face: a cell is a little more than a pixel
_WIDTH_PX = 100.0  # any width of the eye: shapes are described in shares of it


def flat_eyes(neutral: NeutralFace) -> np.ndarray | None:
    """(27, 48, 3) float32: the roots of the shares of skin, the mean over the eyes that are seen.

    None when none is seen.
    """
    soft = cv2.GaussianBlur(neutral.linear, (0, 0), _BLUR_PX)
    eyes = [neutral.roots(_laid_flat(soft, lid)) for lid in lid_surfaces(neutral.face)]
    if not eyes:
        return None
    mean: np.ndarray = np.stack(eyes).mean(0, dtype=np.float32)
    return mean


def _laid_flat(linear: np.ndarray, lid: LidSurface) -> np.ndarray:
    rows, columns = np.arange(SIZE_WH[1]), np.arange(SIZE_WH[0])
    below = lid.below_px / np.float32(lid.width_px)
    y = np.empty(FLAT_HW, np.float32)
    for column in columns:  # heights fall from row to row, so the places are found by them
        y[: len(_UP), column] = np.interp(-_UP, -lid.up[:, column], rows)
        y[len(_UP) :, column] = np.interp(-_DOWN * LID, below[:, column], rows)
    on_grid = np.stack([np.broadcast_to(columns, FLAT_HW), y, np.ones_like(y)]).reshape(3, -1)
    places = (lid.grid.to_px @ on_grid).astype(np.float32)
    return remap(linear, places).reshape(*FLAT_HW, 3)


@lru_cache(maxsize=64)
def density(layer: Layer) -> np.ndarray:
    """(27, 48) float32: how densely a layer of eye-shadow lies on each cell, 0..1."""
    flat = np.zeros(FLAT_HW, np.float32)
    for fields, rows in zip(_fields(), (slice(0, len(_UP)), slice(len(_UP), None)), strict=True):
        for coat in KINDS[layer.kind].coats(fields, layer.product, layer.whole_shape):
            if coat.density is not None:
                flat[rows] = np.broadcast_to(coat.density, (1, *FLAT_HW))[0, rows]
    flat.setflags(write=False)
    return flat


@lru_cache(maxsize=1)
def _fields() -> tuple[EyeFields, EyeFields]:
    """The fields of a flat eye: above it, and below it."""
    up = np.broadcast_to(HEIGHTS[:, None], FLAT_HW)[None]
    away_px = up * np.float32(LID * _WIDTH_PX)
    lids = up, away_px, -away_px
    across, wide = np.broadcast_to(_ACROSS, FLAT_HW), np.full((1, 1, 1), _WIDTH_PX, np.float32)
    above, below = (
        EyeFields(is_upper, across, up[0] * LID, lids, wide, lambda: np.zeros((1, 1, 1)))
        for is_upper in (True, False)
    )
    return above, below
