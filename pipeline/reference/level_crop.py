"""Close crops of a face in which two of its points lie level, as small nets see them."""

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.affine import AffineArray


def level_place(
    face: Face,
    ends: tuple[int, int],
    apart_px: float,
    size_wh: tuple[int, int],
    below_px: float = 0.0,
) -> AffineArray:
    """The affine map from px of a crop to px of the photo.

    ends: the two points of the face that lie level in the crop, the left one first.
    apart_px: how far apart they lie, in px of the crop.  below_px: how far the centre of the crop
    lies below the middle between them, in px of the crop.
    """
    left, right = face.points_px[list(ends), :2].astype(np.float64)
    along = right - left
    if not along.any():  # the two ends coincide: any rotation will do
        along = np.array([1.0, 0.0])
    linear = np.column_stack([along, (-along[1], along[0])]) / apart_px
    centre = (np.array(size_wh) - 1) / 2 - [0, below_px]
    return np.column_stack([linear, (left + right) / 2 - linear @ centre])
