"""The light on a face of a photo."""

import math

import cv2
import numpy as np
from makeup_video.kernels.colour import SRGB, to_linear
from makeup_video.pipeline.faces.face import Face, FrameFaces, iod_px, resized
from makeup_video.pipeline.frames.rgb import to_frame
from makeup_video.pipeline.render.scene import SceneLight
from makeup_video.pipeline.render.scene_light import light_of

# Light is read from a copy whose outer eye corners are this far apart, as in training, and that has
# no more pixels than this. With the eyes 20 px apart, the light is still the same within 1 %.
_LIGHT_IOD_PX, _LIGHT_PX = 69, 1_000_000
_DARKEST = 0.05  # least light that is divided out: below it there is only noise


def photo_light(rgb8: np.ndarray, face: Face) -> SceneLight:
    """The light on a face, read from the whole photo."""
    h, w = rgb8.shape[:2]
    scale = min(1.0, _LIGHT_IOD_PX / iod_px(face), math.sqrt(_LIGHT_PX / (h * w)))
    size_wh = max(1, round(scale * w)), max(1, round(scale * h))
    small = cv2.resize(rgb8, size_wh, interpolation=cv2.INTER_AREA) if scale < 1 else rgb8
    frame = to_frame(np.ascontiguousarray(small[..., ::-1]))
    return light_of(FrameFaces(frame, (resized(face, scale, scale),)))[0]


def neutral_table(light: SceneLight) -> np.ndarray:
    """(256, 3) float64: the linear light that each code of R, G and B, as sRGB encodes it, would
    have in neutral light of full strength. It may exceed 1."""
    gain = np.maximum(light.colour.astype(np.float64) * light.strength, _DARKEST)
    table: np.ndarray = to_linear(np.repeat(np.arange(256)[:, None] / 255, 3, axis=1), SRGB) / gain
    return table
