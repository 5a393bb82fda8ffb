"""Input of the net that reads which makeup is worn: eyes, face and lips in one picture."""

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.views import Crop, RgbPicture
from makeup_video.pipeline.reference.crops import divide_light, eyes_middle, turned_crop
from makeup_video.pipeline.render.scene import SceneLight

# The size of the picture, and the place of each part in it: left, top, width, height; px.
INPUT_WH = (192, 160)
PLACES = {"eyes": (0, 0, 192, 64), "face": (0, 64, 96, 96), "lips": (96, 64, 96, 64)}
# The width of each part, and how far its middle lies below the middle between the eyes, in IOD.
_SPANS = {"eyes": (1.5, -0.03), "face": (2.0, 0.42), "lips": (0.9, 0.72)}


def makeup_input(rgb8: np.ndarray, face: Face, light: SceneLight) -> np.ndarray:
    """(160, 192, 3) uint8 in neutral light, from a picture (H, W, 3) uint8.

    In and out: R'G'B' as sRGB encodes it. The parts are turned with the face. Beyond the border of
    the picture its last pixels are repeated. The lower right corner, a tenth of the result, is
    black.
    """
    picture = RgbPicture(rgb8)
    seen = np.zeros((*INPUT_WH[::-1], 3), np.uint8)
    for part, (left, top, wide, high) in PLACES.items():
        seen[top : top + high, left : left + wide] = picture.crop(*_crop(face, part))
    return divide_light(seen, light)


def _crop(face: Face, part: str) -> Crop:
    (span, below), (*_, wide, high) = _SPANS[part], PLACES[part]
    return turned_crop(face, eyes_middle(face), -below, span, (wide, high))


def mirrored(seen: np.ndarray) -> np.ndarray:
    """Inputs (..., 160, 192, 3) with every part mirrored in its place."""
    other = seen.copy()
    for left, top, wide, high in PLACES.values():
        at = np.s_[..., top : top + high, left : left + wide, :]
        other[at] = seen[at][..., ::-1, :]
    return other
