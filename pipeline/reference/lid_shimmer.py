"""Measures how much the upper lids of a photo shimmer, by how far fine highlights stand out.

Light on matte powder is even, while shimmer has bright specks and edges. A speck has to be brighter
than both the lid around it and the lid as a whole; otherwise the gaps between dark lashes would
count as specks.
"""

import cv2
import numpy as np
from makeup_video.kernels.colour import SRGB, to_linear
from makeup_video.pipeline.faces.face import Face, iod_px, resized
from makeup_video.pipeline.frames.views import RgbPicture
from makeup_video.pipeline.reference.checks import is_inside
from makeup_video.pipeline.reference.crops import CROPS, read_input
from makeup_video.pipeline.reference.flat_lids import flat_places_across, flat_rings
from makeup_video.pipeline.reference.neutral_face import LUMINANCE
from makeup_video.pipeline.render.scene import SceneLight

_EYES = CROPS["eyes"]
# The distance of the outer eye corners in the crop of the eyes. Faces with a larger distance are
# averaged down to it, so that "fine" means the same in photos of all sizes.
_IOD_PX = _EYES.crop_wh[0] / _EYES.span
_RINGS = 0.25, 1.8  # skin between these heights counts: lash line 0, crease 1, fold 2
_BESIDE = 0.42  # skin counts up to this distance from the eye's middle, in widths of the eye
_FINE_PX = 1.5  # sigma of the blur that removes fine highlights
_DARK = 0.01  # linear light added before the logarithm, so that noise in the dark hardly counts
_PERCENTILE = 95
# The values of fine_highlights, and the shimmer painted for each. They were chosen so that people
# judge painted lids as they judge the lids in the photos.
_MEASURED = (0.09, 0.13, 0.19, 0.24)
_SHIMMER = (0.0, 0.25, 0.5, 1.0)


def lids_of(rgb8: np.ndarray, face: Face, light: SceneLight) -> np.ndarray | None:
    """Both lids laid flat as by flat_lids, in neutral light: (64, 160, 3) uint8, R'G'B'.

    rgb8: (H, W, 3) uint8, R'G'B'.  None when the eyes lie beyond its border or cannot be seen.
    """
    if not is_inside(rgb8, face, _EYES.needed):
        return None
    scale = _IOD_PX / iod_px(face)
    if scale < 1:
        rgb8 = cv2.resize(rgb8, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        face = resized(face, scale, scale)
    return read_input(RgbPicture(rgb8), face, "eyes", light)


def lid_shimmer(lids: np.ndarray) -> float:
    """How strong the shimmer of eyeshadow is, 0..1.

    lids: (64, 160, 3) uint8, from lids_of.
    """
    return float(np.interp(fine_highlights(lids), _MEASURED, _SHIMMER))


def fine_highlights(lids: np.ndarray) -> float:
    """How much the brightest twentieth of the lids stands out at least, in natural logarithms.

    lids: as for lid_shimmer.
    """
    light = np.log(to_linear(lids / 255, SRGB) @ LUMINANCE + _DARK).astype(np.float32)
    low, high = _RINGS
    rows, columns = flat_rings(), np.abs(flat_places_across())
    there = np.ix_((rows > low) & (rows < high), columns < _BESIDE)
    around = np.maximum(cv2.GaussianBlur(light, (0, 0), _FINE_PX), np.median(light[there]))
    return float(np.percentile((light - around)[there], _PERCENTILE))
