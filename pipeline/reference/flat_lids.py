"""Lays both lids flat, for the reference net of the eyes and for lid_shimmer.py.

Lids are thin, and their height differs from face to face, so in a plain crop a net spends its
capacity on finding them. In the flat picture every zone has a fixed place. A row lies at a fixed
height among the mesh's rings (lash line, crease and fold), and a column at a fixed place between
the corners. The eye and some skin follow below the lash line.
"""

import cv2
import numpy as np
from makeup_video.kernels.surface import LID_LEFT, LID_STEP
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.affine import AffineArray
from makeup_video.pipeline.render.grid import Grid
from makeup_video.pipeline.render.surfaces.both_eyes import SIZE_WH
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_curves

FLAT_WH = (160, 64)  # px: both eyes beside each other, with their outer corners outside
_ABOVE = 46  # number of rows from above the fold to the lash line
_HIGHEST = 2.2  # place of the first row among the rings: lash line 0, crease 1, fold 2
_LOWEST = 0.5  # distance of the last row below the lash line, in widths of the eye
_APART = 1.9 / 39  # least distance of the curves in widths of the eye, as in the net's training
_OUT = (-0.72, 0.92)  # place of the first and the last column: inner corner -0.5, outer corner 0.5
# Of one eye: places of the upper rows among the rings, distances of the lower rows below the lash
# line, and places of the columns.
_UP = np.linspace(_HIGHEST, 0, _ABOVE)
_DOWN = np.linspace(0, _LOWEST, FLAT_WH[1] - _ABOVE + 1)[1:]
_ACROSS = np.linspace(*_OUT, FLAT_WH[0] // 2)


def flat_lids(face: Face, to_crop: AffineArray) -> np.ndarray | None:
    """Where in a crop each pixel of the flat lids lies: (2, 64, 160) float32, x and y.

    to_crop: (2, 3), picture px -> crop px. An eye that cannot be seen is replaced by the mirror
    image of the other eye. None when neither eye can be seen.
    """
    places = [None if eye is None else _places(*eye) for eye in lid_curves(face)]
    seen = [eye for eye in places if eye is not None]
    if not seen:
        return None
    left, right = (seen[0] if eye is None else eye for eye in places)
    both = np.concatenate([left[:, :, ::-1], right], axis=2)
    in_crop: np.ndarray = cv2.transform(both.transpose(1, 2, 0), to_crop)
    return in_crop.transpose(2, 0, 1).astype(np.float32)


def flat_rings() -> np.ndarray:
    """(64,) the place of each row among the mesh's rings: lash line 0, crease 1, fold 2.

    For rows below the lash line: minus their distance from it, in widths of the eye.
    """
    return np.concatenate([_UP, -_DOWN])


def flat_places_across() -> np.ndarray:
    """(160,) the places of the columns across their eye: inner corner -0.5, outer corner 0.5."""
    return np.concatenate([_ACROSS[::-1], _ACROSS])


def _places(grid: Grid, curves: np.ndarray) -> np.ndarray:
    """(2, 64, 80): where each pixel of one flat eye lies in the picture, x and y, in px.

    curves: lash line, crease and fold on the eye's grid.
    """
    lash, crease, fold = curves
    crease = np.minimum(crease, lash - _APART / LID_STEP)
    fold = np.minimum(fold, crease - _APART / LID_STEP)
    columns = (_ACROSS - LID_LEFT) / LID_STEP
    lash, crease, fold = (
        np.interp(columns, np.arange(SIZE_WH[0]), curve) for curve in (lash, crease, fold)
    )
    up = _UP[:, None]
    above = np.where(up < 1, lash - up * (lash - crease), crease - (up - 1) * (crease - fold))
    y = np.concatenate([above, lash + _DOWN[:, None] / LID_STEP])
    on_grid = np.stack([np.broadcast_to(columns, y.shape), y, np.ones_like(y)])
    places: np.ndarray = np.einsum("ij,jhw->ihw", grid.to_px, on_grid)
    return places
