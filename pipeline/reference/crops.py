"""What the reference net is shown and what it tells: crops of lips and eyes, seven numbers."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from makeup_video.kernels.colour import SRGB, to_encoded, to_linear
from makeup_video.pipeline.faces.face import PATCH_SPAN, Face
from makeup_video.pipeline.faces.topology import EYE_CORNERS
from makeup_video.pipeline.frames.affine import AffineArray, compose, invert
from makeup_video.pipeline.frames.sampling import pixel_places
from makeup_video.pipeline.frames.views import Crop, RgbPicture
from makeup_video.pipeline.reference.flat_lids import FLAT_WH, flat_lids
from makeup_video.pipeline.render.scene import SceneLight

# The paper's g, in the order of the net's output.
NUMBERS = ("opacity", "red", "green", "blue", "gloss", "gloss_roughness", "reflection")
_GLOSS = NUMBERS.index("gloss")
_GLOSS_UNIT = 4.0  # of gloss is 1 for the net, and the most that it was ever shown
_UNITS = np.array([1, 255, 255, 255, _GLOSS_UNIT, 1, 1], np.float64)
_DARKEST = 0.05  # least light that is divided out: below there is only noise


@dataclass(frozen=True, slots=True)
class _Crop:
    """A window turned with the face, and what the net sees of it."""

    size_wh: tuple[int, int]  # px, of what the net sees
    window_wh: tuple[int, int]  # px
    span: float  # the window's width, in IOD
    rise: float  # of its middle above the lips' or the eye corners' middle, in IOD


CROPS = {
    "lips": _Crop((128, 96), (128, 96), 0.9, 0.0),
    "eyes": _Crop(FLAT_WH, (176, 72), 1.42, -0.01),
}


def window_of(face: Face, region: str) -> Crop:
    """The part of a picture around a region, "lips" or "eyes", upright on the face.

    Scale and turn are those of the face's lip patch, for the eyes too.
    """
    crop, patch = CROPS[region], face.lips
    high, wide = patch.logits.shape
    axes = patch.to_px[:, :2] * (wide / PATCH_SPAN)  # px of the picture for one IOD
    if region == "lips":
        middle = patch.to_px @ [(wide - 1) / 2, (high - 1) / 2, 1]
    else:
        middle = face.points_px[list(EYE_CORNERS), :2].mean(0, dtype=np.float64)
    middle = middle - axes @ [0, crop.rise]
    w, h = crop.window_wh
    linear = axes * (crop.span / w)
    return np.column_stack([linear, middle - linear @ [(w - 1) / 2, (h - 1) / 2]]), crop.window_wh


def places_of(face: Face, region: str) -> np.ndarray | None:
    """Where in its window (px) each pixel of a region's crop lies, (2, H, W) float32.

    None when the eyes are not seen. Lips are shown as they are, lids laid flat.
    """
    if region == "eyes":
        return flat_lids(face, invert(window_of(face, region)[0]))
    return pixel_places(CROPS[region].size_wh)[:2].reshape(2, *CROPS[region].size_wh[::-1])


def crop_of(window: np.ndarray, places: np.ndarray, light: SceneLight) -> np.ndarray:
    """What the net is shown of a window (h, w, 3) uint8: (H, W, 3), in neutral light."""
    x, y = places
    seen = cv2.remap(window, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return divide_light(seen, light)


def read_crop(picture: RgbPicture, face: Face, region: str, light: SceneLight) -> np.ndarray | None:
    """What the net of a region is shown of a picture, (H, W, 3); None when the eyes are not seen."""
    places = places_of(face, region)
    if places is None:
        return None
    return crop_of(picture.crop(*window_of(face, region)), places, light)


def shifted(window: Crop, turn: float, scale: float, shift_xy: np.ndarray) -> AffineArray:
    """A window's map when it is turned (radians), scaled and shifted (its own px) about its middle."""
    to_px, (w, h) = window
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    linear, middle = np.array([[c, -s], [s, c]]), np.array([(w - 1) / 2, (h - 1) / 2])
    return compose(to_px, np.column_stack([linear, middle + shift_xy - linear @ middle]))


def divide_light(rgb8: np.ndarray, light: SceneLight) -> np.ndarray:
    """(..., 3) uint8 as it would be in neutral light of full strength; what is too bright is white.

    rgb8, in and out: R'G'B' as sRGB encodes it. So a product has the colour of its g, whatever
    the light of the photo.
    """
    gain = np.maximum(light.colour.astype(np.float64) * light.strength, _DARKEST)
    codes = np.repeat(np.arange(256)[:, None] / 255, 3, axis=1)
    table = to_encoded(to_linear(codes, SRGB) / gain, SRGB).clip(0, 1)
    divided: np.ndarray = cv2.LUT(rgb8, np.rint(255 * table).astype(np.uint8)[None])
    return divided


def to_targets(values: np.ndarray) -> np.ndarray:
    """(..., 7) as in a look -> (..., 7) as the net tells them, about 0 to 1."""
    targets = np.asarray(values, np.float64) / _UNITS
    # a little gloss is seen more easily than a little more of it
    targets[..., _GLOSS] = np.sqrt(targets[..., _GLOSS])
    return targets


def from_targets(targets: np.ndarray) -> np.ndarray:
    """What the net tells -> numbers of a look, in the ranges that it was trained on."""
    values: np.ndarray = np.clip(np.asarray(targets, np.float64), 0, 1)
    values[..., _GLOSS] **= 2
    return values * _UNITS


def numbers_told(targets_of: Callable[[np.ndarray], np.ndarray], crop: np.ndarray) -> np.ndarray:
    """(7,) numbers of a look that a net tells of a crop (H, W, 3): the mean of it and its mirror image,
    for they wear the same.  targets_of: crops (N, H, W, 3) -> (N, 7)."""
    return from_targets(targets_of(np.stack([crop, crop[:, ::-1]])).mean(0))
