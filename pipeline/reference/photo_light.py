"""The light on a face of a photo."""

import math

import cv2
import numpy as np
from makeup_video.kernels.colour import SRGB, to_linear
from makeup_video.pipeline.faces.face import Face, FrameFaces, iod_px, resized
from makeup_video.pipeline.frames.rgb import to_frame
from makeup_video.pipeline.render.scene import SceneLight
from makeup_video.pipeline.render.scene_light import light_of

# The light is read from a copy that is at most so large: px between the outer eye corners, as in
# training, and px of the copy. With 20 px between the corners the light is the same within 1 %.
_LIGHT_IOD_PX, _LIGHT_PX = 69, 1_000_000
_DARKEST = 0.05  # the least light that is divided out: with less there is only noise


def photo_light(rgb8: np.ndarray, face: Face) -> SceneLight:
    """The light on a face, read from the whole photo."""
    h, w = rgb8.shape[:2]
    scale = min(1.0, _LIGHT_IOD_PX / iod_px(face), math.sqrt(_LIGHT_PX / (h * w)))
    size_wh = max(1, round(scale * w)), max(1, round(scale * h))
    small = cv2.resize(rgb8, size_wh, interpolation=cv2.INTER_AREA) if scale < 1 else rgb8
    frame = to_frame(np.ascontiguousarray(small[..., ::-1]))
    return light_of(FrameFaces(frame, (resized(face, scale, scale),)))[0]


def neutral_table(light: SceneLight) -> np.ndarray:
    """(256, 3) float64: each code of R', G' and B' -> linear in neutral light of full strength.

    The codes are sRGB's. The values may exceed 1.
    """
    gain = np.maximum(light.colour.astype(np.float64) * light.strength, _DARKEST)
    table: np.ndarray = to_linear(np.repeat(np.arange(256)[:, None] / 255, 3, axis=1), SRGB) / gain
    return table
