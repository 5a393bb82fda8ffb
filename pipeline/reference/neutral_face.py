"""A face of a photo in neutral light and at one size, on which colours of makeup are measured."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from makeup_video.kernels.colour import to_xyz
from makeup_video.pipeline.faces.face import Face, iod_px, moved
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.frames.affine import invert
from makeup_video.pipeline.frames.sampling import sample
from makeup_video.pipeline.reference.photo_light import neutral_table
from makeup_video.pipeline.render.scene import SceneLight

IOD_PX = 120  # distance of the outer eye corners, unless a small face would be enlarged too much
_MOST_ENLARGED = 2.0
_MARGIN = 0.35  # around the points of the face, in IOD
_FAINTEST = 1e-3  # below this linear light, or share of skin's light, there is only noise
# Skin that hardly anybody makes up, as closed contours of the face's points: forehead, ridge of the
# nose, and beside the mouth. The mirror image of each contour counts, too.
PLAIN_SKIN = (
    (108, 151, 337, 338, 10, 109),
    (6, 197, 195, 5, 4, 45, 220, 196),
    (207, 214, 212, 216),
)
# The median light of these three places is the measure. A place with less light than this share of
# it does not count, since hair, a beard or a hat hides it. Hair over the forehead may be light.
_HIDDEN = (0.65, 0.4, 0.4)
LUMINANCE = to_xyz(1)[1]  # weights of sRGB's linear R, G, B


@dataclass(frozen=True, slots=True, eq=False)
class NeutralFace:
    """A face in neutral light of full strength.

    rgb8: (H, W, 3) uint8, the face's part of the photo, at this size, in the photo's own light.
    linear: (H, W, 3) float32, in neutral light, linear R, G, B of sRGB. A pixel that shows a
    product of colour p has the value p.
    face: in px of these pictures.
    skin: (3,) linear R, G, B of plain skin.
    light: (3,) linear R, G, B of the light that was divided out, mean 1.
    """

    rgb8: np.ndarray
    linear: np.ndarray
    face: Face
    skin: np.ndarray
    light: np.ndarray

    def roots(self, linear: np.ndarray) -> np.ndarray:
        """Linear colours (..., 3) -> square roots of their shares of skin; films mix by these."""
        roots: np.ndarray = np.sqrt(np.maximum(linear / self.skin, _FAINTEST))
        return roots


def neutral_face(rgb8: np.ndarray, face: Face, light: SceneLight) -> NeutralFace:
    """Cut the face out of a photo, and divide its light out.

    rgb8: (H, W, 3) uint8, R'G'B' as sRGB encodes it.
    """
    iod = iod_px(face)
    scale = min(_MOST_ENLARGED, IOD_PX / iod)
    xy = face.points_px[:, :2].astype(np.float64)
    low, high = xy.min(0) - _MARGIN * iod, xy.max(0) + _MARGIN * iod
    to_crop = np.array([[scale, 0, -scale * low[0]], [0, scale, -scale * low[1]]])
    wide, tall = np.ceil((high - low) * scale).astype(int).tolist()
    crop, crop_face = sample(rgb8, invert(to_crop), (wide, tall)), moved(face, to_crop)
    linear = cv2.LUT(crop, neutral_table(light).astype(np.float32)[None])
    colour = light.colour / light.colour.mean()
    return NeutralFace(crop, linear, crop_face, _skin(linear, crop_face), colour)


def filled(
    face: Face, contours: Sequence[Sequence[int]], hw: tuple[int, ...], *, mirrored: bool
) -> np.ndarray:
    """(h, w) bool: the pixels within closed contours of the face's points.

    mirrored: include the pixels within the contours' mirror images on the face.
    """
    inside = np.zeros(hw[:2], np.uint8)
    points = np.rint(face.points_px[:, :2]).astype(np.int32)
    both = [np.array(contour) for contour in contours]
    if mirrored:
        mirror = read_array("mirror.npy").astype(int)
        both += [mirror[contour] for contour in both]
    for contour in both:
        cv2.fillPoly(inside, [points[contour]], 1)
    there: np.ndarray = inside > 0
    return there


def _skin(linear: np.ndarray, face: Face) -> np.ndarray:
    """(3,) the linear median of the plain skin that can be seen."""
    places = [
        (share, place)
        for share, contour in zip(_HIDDEN, PLAIN_SKIN, strict=True)
        if len(place := linear[filled(face, [contour], linear.shape, mirrored=True)])
    ]
    if not places:
        return np.full(3, 0.5)
    light = [float(np.median(place @ LUMINANCE)) for _, place in places]
    middle = float(np.median(light))
    seen = [
        place for (share, place), here in zip(places, light, strict=True) if here >= share * middle
    ]
    skin: np.ndarray = np.maximum(np.median(np.concatenate(seen), axis=0), _FAINTEST)
    return skin
