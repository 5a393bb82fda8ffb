"""Lays the skin around both eyes flat: every place between lashes, crease and brow has its cell.

A column is a place across the eye, as on the eyes' surface. A row is a height of EyePlaces
(look/kinds/fields.py): the first rows lie above the upper lash line, the others below the lower
one. So the maps of different faces can be compared cell by cell, and a shape of eyeshadow covers
the same cells of every face.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from makeup_video.pipeline.faces.topology import FACE_OVAL
from makeup_video.pipeline.frames.sampling import remap
from makeup_video.pipeline.look.ciede2000 import lab_of_linear
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.density_map import heights
from makeup_video.pipeline.look.kinds.fields import LID, EyeChart
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.neutral_face import LUMINANCE, NeutralFace, filled
from makeup_video.pipeline.render.skin_light import TYPICAL_SKIN
from makeup_video.pipeline.render.surfaces.both_eyes import ACROSS, SIZE_WH
from makeup_video.pipeline.render.surfaces.eyes import NUMBERS, LidSurface
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces

_UP, _DOWN = heights(True), heights(False)
_HEIGHTS = np.concatenate([_UP, _DOWN])
FLAT_HW = len(_HEIGHTS), SIZE_WH[0]
_BLUR_PX = 0.9  # sigma, px of the neutral face, where a cell is a little larger than a pixel
# A column is dark when this percentile of the light of its cells is below this share of skin's
# light. It is off the face when less than this share of its cells lies within the face's outline.
# A column that is either, like all columns further out, shows hair, or the background of a face
# that is turned away. The inner columns always count, since black there is makeup.
_PERCENTILE, _DARK = 80, 0.2
_ON_FACE = 0.5
_INNER = FLAT_HW[1] // 2
# Eyes are compared between these places across them. They wear different colours when their a* and
# b* differ by at least this distance on average. In the six photos in which people see different
# eyes it is 13.8 to 40; in 115 others with sure eyeshadow at most 12.5, in light from one side.
_COMPARED = 0.1, 1.15
_DIFFERENT = 13.0


class FlatEye(NamedTuple):
    """An eye of a face, laid flat.

    name: as the dial `eye` names the eye.  roots: (27, 48, 3) float32, of shares of skin.
    is_skin: (48,) bool, the columns that neither hair nor background hides.
    """

    name: str
    roots: np.ndarray
    is_skin: np.ndarray


def mean_eye(eyes: Sequence[FlatEye]) -> np.ndarray | None:
    """(27, 48, 3) float32: the mean over the eyes, roots of shares of skin; None without eyes.

    eyes: from eyes_of.

    A column that is hidden beside one eye, by hair or beyond the outline of a turned face, comes
    from the other eye alone. A column that is hidden beside both counts as plain skin.
    """
    if not eyes:
        return None
    seen = np.stack([eye.is_skin for eye in eyes])[:, None, :, None]
    roots = [eye.roots for eye in eyes]
    mean: np.ndarray = np.where(
        seen.any(0), np.sum(roots, 0, where=seen) / np.maximum(seen.sum(0), 1), np.float32(1)
    ).astype(np.float32)
    return mean


def different_eyes(eyes: Sequence[FlatEye]) -> dict[str, np.ndarray]:
    """Both eyes, (27, 48, 3) each, by name, if they wear different colours; else an empty dict.

    eyes: from eyes_of.  The names are those of the dial `eye`. Hidden columns are plain skin.
    """
    if len(eyes) < 2:
        return {}
    low, high = _COMPARED
    seen = (low < ACROSS) & (high > ACROSS) & eyes[0].is_skin & eyes[1].is_skin
    if not seen.any():
        return {}
    first, second = (lab_of_linear(eye.roots[:, seen] ** 2 * TYPICAL_SKIN) for eye in eyes)
    off = float(np.linalg.norm((first - second)[..., 1:], axis=-1).mean())
    if off < _DIFFERENT:
        return {}
    return {eye.name: np.where(eye.is_skin[:, None], eye.roots, np.float32(1)) for eye in eyes}


def eyes_of(neutral: NeutralFace) -> list[FlatEye]:
    """The eyes that are seen, each laid flat."""
    soft = cv2.GaussianBlur(neutral.linear, (0, 0), _BLUR_PX)
    within = filled(neutral.face, [FACE_OVAL.tolist()], soft.shape, mirrored=False)
    names, eyes = {number: name for name, number in NUMBERS.items()}, []
    for lid in lid_surfaces(neutral.face):
        places = _flat_places_px(lid)
        roots = neutral.roots(remap(soft, places).reshape(*FLAT_HW, 3))
        on_face = remap(within.astype(np.float32), places).reshape(FLAT_HW)
        eyes.append(FlatEye(names[lid.number], roots, _is_skin(roots, on_face)))
    return eyes


def is_seen(flat: np.ndarray) -> np.ndarray:
    """(48,) bool: the columns of flat eyes, (27, 48, 3), that are not hidden beside both eyes."""
    seen: np.ndarray = (flat != 1).any((0, 2))
    return seen


def flat_places() -> tuple[np.ndarray, np.ndarray]:
    """Where flat eyes' columns, (48,), and rows, (27,), lie: `across` and `height` of EyePlaces."""
    return ACROSS, _HEIGHTS


def _is_skin(eye: np.ndarray, on_face: np.ndarray) -> np.ndarray:
    """(48,) bool: the columns of a flat eye (27, 48, 3) that neither hair nor background hides.

    on_face: (27, 48), 0..1, the share of each cell within the face's outline.
    """
    hidden = np.percentile(eye * eye @ LUMINANCE, _PERCENTILE, axis=0) < _DARK
    hidden |= on_face.mean(0) < _ON_FACE
    hidden[:_INNER] = False
    hidden = np.logical_and.accumulate(hidden[::-1])[::-1]
    hidden[:-1] |= hidden[1:]  # where hair begins, a column has some of both
    return ~hidden


def _flat_places_px(lid: LidSurface) -> np.ndarray:
    """(2, 27 * 48) float32: where the cells of a flat eye lie in the picture, x and y, in px."""
    rows, columns = np.arange(SIZE_WH[1]), np.arange(SIZE_WH[0])
    below = lid.below_px / np.float32(lid.width_px)
    y = np.empty(FLAT_HW, np.float32)
    for column in columns:  # heights fall from row to row, so interpolation finds the rows
        y[: len(_UP), column] = np.interp(-_UP, -lid.up[:, column], rows)
        y[len(_UP) :, column] = np.interp(-_DOWN * LID, below[:, column], rows)
    on_grid = np.stack([np.broadcast_to(columns, FLAT_HW), y, np.ones_like(y)]).reshape(3, -1)
    places: np.ndarray = (lid.grid.to_px @ on_grid).astype(np.float32)
    return places


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
    """The places of all cells of a flat eye, as above the eye and as below it."""
    across = np.broadcast_to(ACROSS, FLAT_HW)[None]
    height = np.broadcast_to(_HEIGHTS[:, None], FLAT_HW)[None]
    return (
        EyeChart(True, across, np.maximum(height, 0)),
        EyeChart(False, across, np.minimum(height, 0)),
    )
