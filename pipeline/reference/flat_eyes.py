"""Lays the skin around both eyes flat: every place between lashes, crease and brow has its cell.

A column is a place across the eye, as on the eyes' surface. A row is a height: the first ones lie
above the upper lash line, in heights of look/kinds/fields.py, the others below the lower one. So
the maps of different faces may be compared cell by cell, and a shape of eyeshadow covers the same
cells of every face.
"""

from functools import lru_cache

import cv2
import numpy as np
from makeup_video.kernels.surface import LID_LEFT, LID_STEP
from makeup_video.pipeline.frames.sampling import remap
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.density_map import heights
from makeup_video.pipeline.look.kinds.fields import LID, EyeChart
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.neutral_face import LUMINANCE, NeutralFace
from makeup_video.pipeline.render.surfaces.both_eyes import SIZE_WH
from makeup_video.pipeline.render.surfaces.eyes import LidSurface
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces

_UP, _DOWN = heights(True), heights(False)
_HEIGHTS = np.concatenate([_UP, _DOWN])
FLAT_HW = len(_HEIGHTS), SIZE_WH[0]
_ACROSS = (LID_LEFT + LID_STEP * np.arange(SIZE_WH[0]) + 0.5).astype(np.float32)
_BLUR_PX = 0.9  # of the neutral face: a cell is a little more than a pixel
# A column is dark when this percentile of the light of its cells is below this share of skin's.
# Where it is dark, and so are all columns further out, it shows hair, or what lies behind a face
# that is turned away. The inner columns always count: what is black there is makeup.
_PERCENTILE, _DARK = 80, 0.2
_INNER = FLAT_HW[1] // 2


def flat_eyes(neutral: NeutralFace) -> np.ndarray | None:
    """(27, 48, 3) float32: the roots of the shares of skin, the mean over the eyes that are seen.

    Columns that hair hides beside one eye are those of the other eye, and plain skin where both are
    hidden. None when no eye is seen.
    """
    soft = cv2.GaussianBlur(neutral.linear, (0, 0), _BLUR_PX)
    eyes = [neutral.roots(_laid_flat(soft, lid)) for lid in lid_surfaces(neutral.face)]
    if not eyes:
        return None
    seen = np.stack([_is_skin(eye) for eye in eyes])[:, None, :, None]
    mean: np.ndarray = np.where(
        seen.any(0), np.sum(eyes, 0, where=seen) / np.maximum(seen.sum(0), 1), np.float32(1)
    ).astype(np.float32)
    return mean


def is_seen(flat: np.ndarray) -> np.ndarray:
    """(48,) bool: the columns of flat eyes, (27, 48, 3), that are not hidden beside both."""
    seen: np.ndarray = (flat != 1).any((0, 2))
    return seen


def flat_places() -> tuple[np.ndarray, np.ndarray]:
    """Where the columns, (48,), and the rows, (27,), of flat eyes lie: `across` and `height` of
    EyePlaces."""
    return _ACROSS, _HEIGHTS


def _is_skin(eye: np.ndarray) -> np.ndarray:
    """(48,) bool: the columns of a flat eye (27, 48, 3) that neither hair nor background hides."""
    hidden = np.percentile(eye * eye @ LUMINANCE, _PERCENTILE, axis=0) < _DARK
    hidden[:_INNER] = False
    hidden = np.logical_and.accumulate(hidden[::-1])[::-1]
    hidden[:-1] |= hidden[1:]  # where hair begins, a column has some of both
    return ~hidden


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
    """(27, 48) float32: how densely a layer of eyeshadow lies on each cell, 0..1."""
    flat = np.zeros(FLAT_HW, np.float32)
    for fields, rows in zip(_charts(), (slice(0, len(_UP)), slice(len(_UP), None)), strict=True):
        for coat in KINDS[layer.kind].coats(fields, layer.product, layer.whole_shape):
            if coat.density is not None:
                flat[rows] = np.broadcast_to(coat.density, (1, *FLAT_HW))[0, rows]
    flat.setflags(write=False)
    return flat


@lru_cache(maxsize=1)
def _charts() -> tuple[EyeChart, EyeChart]:
    """The places above a flat eye, and below it."""
    across = np.broadcast_to(_ACROSS, FLAT_HW)[None]
    height = np.broadcast_to(_HEIGHTS[:, None], FLAT_HW)[None]
    return (
        EyeChart(True, across, np.maximum(height, 0)),
        EyeChart(False, across, np.minimum(height, 0)),
    )
