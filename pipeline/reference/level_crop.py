"""Places close crops for the small nets: a line of the face, such as the mouth, lies level."""

import numpy as np
from makeup_video.pipeline.frames.affine import AffineArray


def level_place(
    along: np.ndarray,
    apart_px: float,
    anchor: np.ndarray,
    anchor_xy: tuple[float, float],
    *,
    is_mirrored: bool = False,
) -> AffineArray:
    """The affine map from px of a crop to px of the photo.

    along: the line, (2,) px of the photo. In the crop it points to the right, apart_px long.
    anchor: (2,) px of the photo, the point that lies at anchor_xy, px of the crop.
    is_mirrored: the crop shows the mirror image.
    """
    if not along.any():  # the line has no length, so any direction will do
        along = np.array([1.0, 0.0])
    right = along / apart_px
    down = (-1 if is_mirrored else 1) * np.array([-right[1], right[0]])
    linear = np.column_stack([right, down])
    return np.column_stack([linear, anchor - linear @ anchor_xy])
