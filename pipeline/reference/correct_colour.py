"""Corrects the colour of a lipstick read from a photo by painting it on the same photo once more.

An opaque lipstick painted over itself should change nothing. What it changes is an error of the
net, in the light and with the camera of this photo. A sheer lipstick does change lips that already
wear it; how much follows from its opacity.
"""

from dataclasses import replace

import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces, iod_px, moved
from makeup_video.pipeline.faces.topology import LIPS
from makeup_video.pipeline.frames.affine import invert
from makeup_video.pipeline.frames.rgb import merge, to_frame
from makeup_video.pipeline.frames.sampling import sample
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.scene import SceneLight

IOD_PX = 140  # distance of the outer eye corners in the crop: enough for a mean colour
COVER = 0.95  # how much opacity 1 hides: what is under it still shows in the texture
GAIN = 0.8  # share of the correction that is applied: the other numbers have errors too
# Below the first opacity nothing is corrected, above the second everything: a photo of a sheer
# lipstick shows more of the lips than of the lipstick.
SHEER, OPAQUE = 0.45, 0.75
BARE_LIPS = np.array([178.5, 119.9, 107.1])  # R'G'B' codes in neutral light: what shows through
_MARGIN = 0.15  # around the lips, of the distance of the eye corners
_CERTAIN, _LEAST_PX = 0.9, 30  # least weight of the px that count, and least number of such px


def correct_colour(
    rgb8: np.ndarray, face: Face, light: SceneLight, lips: GraphicsParams
) -> GraphicsParams:
    """The lipstick with its colour corrected.

    rgb8: (H, W, 3) uint8, R'G'B' as sRGB encodes it, the photo that `lips` was read from.
    """
    share = GAIN * _smoothstep((lips.opacity - SHEER) / (OPAQUE - SHEER))
    if not share:
        return lips
    crop, crop_face = _crop_lips(rgb8, face)
    painted, inside = _paint(crop, crop_face, light, lips)
    if inside.sum() < _LEAST_PX:
        return lips
    colour = np.array([lips.red, lips.green, lips.blue])
    through = lips.opacity * (1 - COVER * lips.opacity) * (colour - BARE_LIPS)
    off = np.median(crop[inside], axis=0) + through - np.median(painted[inside], axis=0)
    red, green, blue = np.clip(colour + share * off / lips.opacity, 0, 255).round(3).tolist()
    return replace(lips, red=red, green=green, blue=blue)


def _crop_lips(rgb8: np.ndarray, face: Face) -> tuple[np.ndarray, Face]:
    """The part of a photo around the lips, (h, w, 3) uint8, and the face in px of it."""
    iod = iod_px(face)
    scale = min(1.0, IOD_PX / iod)
    lips = face.points_px[LIPS, :2].astype(np.float64)
    low, high = lips.min(0) - _MARGIN * iod, lips.max(0) + _MARGIN * iod
    to_crop = np.array([[scale, 0, -scale * low[0]], [0, scale, -scale * low[1]]])
    wide, tall = np.ceil((high - low) * scale).astype(int).tolist()
    return sample(rgb8, invert(to_crop), (wide, tall)), moved(face, to_crop)


def _paint(
    rgb8: np.ndarray, face: Face, light: SceneLight, lips: GraphicsParams
) -> tuple[np.ndarray, np.ndarray]:
    """The picture with the lipstick on, (H, W, 3) uint8, and where it covers, (H, W) bool."""
    stored = np.ascontiguousarray(rgb8[..., ::-1])
    frame = to_frame(stored)
    before = [plane.copy() for plane in frame.planes]
    scene = BuildScene().under((light,), FrameFaces(frame, (face,)))
    weight = np.zeros(rgb8.shape[:2], np.float32)
    for lit in scene.faces[0].regions["lips"]:
        lit.surface.weigh(weight, (0, 0), lips.edge_softness, None)
    painted = Composite(Look(lips=lips))(scene)
    return merge(stored, painted, before)[..., ::-1], weight > _CERTAIN


def _smoothstep(x: float) -> float:
    x = min(max(x, 0.0), 1.0)
    return x * x * (3 - 2 * x)
