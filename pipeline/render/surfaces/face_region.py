"""The whole face as a region, which is read only for looks that paint it.

While a face rests in the same light, its surface serves up to three frames of one slot of time.
"""

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.frames.clock import slot
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.render.grid import Grid
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.render.surfaces.face import (
    FaceOnGrid,
    FaceSurface,
    face_kernel,
    face_on_grid,
    surface_at,
)
from makeup_video.pipeline.render.surfaces.face_points import fit_points
from makeup_video.pipeline.render.surfaces.region import Reader

# How often a surface may be used again, only in the slot of time in which it was made.
_MOST_USES, SLOT_SECONDS = 2, 0.1
# The largest changes with which it still holds: points moved, in px of the grid (1.6 % of the eyes'
# distance); luma of a quarter of the face, as a share of its range; weight of the mouth.
_MOVED_PX, _LIT_ANEW, _HIDDEN = 0.4, 4 / 255, 0.05


@dataclass(slots=True, eq=False)
class KeptFace:
    """The surface of a face, and what it was made from.

    luma: (4,) float32, `_luma_of`.
    made_seconds, last_seconds: when it was made, and last used.
    uses: how often it was used again.
    """

    surface: FaceSurface
    shading: np.ndarray
    mean: float
    at: FaceOnGrid
    luma: np.ndarray
    mouth_weight: float
    made_seconds: float
    last_seconds: float
    uses: int = 0

    def grid_of(self, face: Face, luma: np.ndarray, seconds: float) -> Grid | None:
        """The grid where the surface lies now; None when a surface made anew might differ."""
        if (
            self.uses >= _MOST_USES
            or self.last_seconds >= seconds
            or slot(seconds, SLOT_SECONDS) != slot(self.made_seconds, SLOT_SECONDS)
            or abs(face.mouth_weight - self.mouth_weight) > _HIDDEN
            or cv2.norm(luma, self.luma, cv2.NORM_INF) > _LIT_ANEW
        ):
            return None
        at = face_on_grid(face, self.at.middle_xy)
        if at is None or cv2.norm(at.points, self.at.points, cv2.NORM_INF) > _MOVED_PX:
            return None
        return at.grid


class FaceRegion:
    """The whole face. Its mean light is not smoothed here: the skin's light is followed already."""

    def lit(self, item: FrameScene, scene: FaceScene, reader: Reader) -> tuple[Lit, ...]:
        face, frame = scene.face, item.frame
        key, seconds, luma = (face.track_id, "face"), frame.seconds, _luma_of(frame, face)
        kept = reader.kept.get(key)
        if kept is not None and (grid := kept.grid_of(face, luma, seconds)) is not None:
            kept.last_seconds, kept.uses = seconds, kept.uses + 1
            surface = kept.surface.on(grid)
        else:
            at = face_on_grid(face)
            if at is None:
                return ()
            made = surface_at(at, face, frame, item.coding, face_kernel(reader.device))
            kept = KeptFace(*made, at, luma, face.mouth_weight, seconds, seconds)
            reader.kept[key], surface = kept, kept.surface
        return (Lit(surface, kept.shading, scene.light.skin or kept.mean),)

    def amount(self, scene: FaceScene) -> float:
        return 1.0

    def shade(self, light: SceneLight, mean: float) -> float:
        return 1.0


FACE = FaceRegion()


def _luma_of(frame: Frame, face: Face) -> np.ndarray:
    """Mean luma of each quarter of a face, as shares of the range: (4,) float32."""
    luma = frame.planes[0]
    high, wide = luma.shape
    xy = face.points_px.take(fit_points(), 0)[:, :2].astype(np.intp)
    np.minimum(np.maximum(xy, 0, out=xy), (wide - 1, high - 1), out=xy)
    codes = luma[xy[:, 1], xy[:, 0]]
    means: np.ndarray = _quarters() @ codes.astype(np.float32)
    means /= 2.0**frame.bit_depth
    return means


@cache
def _quarters() -> np.ndarray:
    """(4, P) float32: the matrix from values at `fit_points` to the means of a face's quarters."""
    x, y = read_array("mean_face.npy")[fit_points(), :2].T
    is_right, is_low = x > 0, y > np.median(y)
    quarter = 2 * is_low + is_right
    there = (quarter == np.arange(4)[:, None]).astype(np.float32)
    share: np.ndarray = there / there.sum(1, keepdims=True)
    return share
