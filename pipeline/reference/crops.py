"""Input and output of the nets of lips and eyes: a crop of the region, and seven numbers."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from makeup_video.kernels.colour import SRGB, to_encoded
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import EYE, EYE_CORNERS, RIGHT_EYE
from makeup_video.pipeline.frames.affine import AffineArray, invert
from makeup_video.pipeline.frames.sampling import pixel_places
from makeup_video.pipeline.frames.views import Crop, RgbPicture
from makeup_video.pipeline.reference.flat_lids import FLAT_WH, flat_lids
from makeup_video.pipeline.reference.photo_light import neutral_table
from makeup_video.pipeline.render.scene import SceneLight

# The graphics parameters that a net reads, in the order of its output.
NUMBERS = ("opacity", "red", "green", "blue", "gloss", "gloss_roughness", "reflection")
_GLOSS = NUMBERS.index("gloss")
_GLOSS_UNIT = 4.0  # this gloss is 1 for the net: the highest in its training
_UNITS = np.array([1, 255, 255, 255, _GLOSS_UNIT, 1, 1], np.float64)


def _lips_middle(face: Face) -> np.ndarray:
    patch = face.lips
    high, wide = patch.logits.shape
    middle: np.ndarray = patch.to_px @ [(wide - 1) / 2, (high - 1) / 2, 1]
    return middle


def eyes_middle(face: Face) -> np.ndarray:
    middle: np.ndarray = face.points_px[list(EYE_CORNERS), :2].mean(0, dtype=np.float64)
    return middle


@dataclass(frozen=True, slots=True)
class _Crop:
    """A crop that is turned with the face, and the net's input that is sampled from the crop.

    input_wh, crop_wh: sizes of the net's input and of the crop, px.  span: width of the crop, IOD.
    middle: finds the middle of the region, (2,) px of the picture.
    rise: how far the centre of the crop lies above that middle, in IOD.
    needed: points of the face that must lie in the picture.
    flatten: given the face and the map from the picture to the crop, finds where in the crop each
    pixel of the input lies, as `input_places` returns it; None: the input is the crop itself.
    """

    input_wh: tuple[int, int]
    crop_wh: tuple[int, int]
    span: float
    middle: Callable[[Face], np.ndarray]
    rise: float = 0.0
    needed: tuple[int, ...] = ()
    flatten: Callable[[Face, AffineArray], np.ndarray | None] | None = None


# The regions that are read from photos. Each has a net, weights/reference_NAME.onnx. Only the
# baseline uses the net of the eyes, but lid_shimmer.py measures shimmer in that net's input.
CROPS = {
    "lips": _Crop((128, 96), (128, 96), 0.9, _lips_middle),
    "eyes": _Crop(
        FLAT_WH, (176, 72), 1.42, eyes_middle, -0.01, (*EYE, *RIGHT_EYE), flatten=flat_lids
    ),
}
CROPPED = tuple(CROPS)


def crop_around(face: Face, region: str) -> Crop:
    """The crop of a picture around a region, a key of CROPS, turned with the face."""
    crop = CROPS[region]
    return turned_crop(face, crop.middle(face), crop.rise, crop.span, crop.crop_wh)


def turned_crop(
    face: Face, middle: np.ndarray, rise: float, span: float, size_wh: tuple[int, int]
) -> Crop:
    """A crop whose centre lies above a point of the picture, turned with the face.

    For every region, the face's lip patch gives scale and turn.
    middle: the point, (2,) px of the picture.  rise: height of the centre above it, in IOD.
    span: width of the crop, in IOD.
    """
    patch, (w, h) = face.lips, size_wh
    axes = patch.to_px[:, :2] * (patch.logits.shape[1] / patch.span)  # px of the picture per IOD
    linear = axes * (span / w)
    centre = middle - axes @ [0, rise]
    return np.column_stack([linear, centre - linear @ [(w - 1) / 2, (h - 1) / 2]]), size_wh


def input_places(face: Face, region: str) -> np.ndarray | None:
    """Where in the crop (px) each pixel of a net's input lies, (2, H, W) float32.

    The crop of the lips is sampled unchanged; lids are laid flat. None when the region cannot be
    seen.
    """
    if (flatten := CROPS[region].flatten) is not None:
        return flatten(face, invert(crop_around(face, region)[0]))
    w, h = CROPS[region].input_wh
    return pixel_places((w, h))[:2].reshape(2, h, w)


def net_input(crop: np.ndarray, places: np.ndarray, light: SceneLight) -> np.ndarray:
    """The input of a net, (H, W, 3) uint8 in neutral light, from a crop (h, w, 3) uint8.

    places: from input_places.
    """
    x, y = places
    sampled = cv2.remap(crop, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return divide_light(sampled, light)


def read_input(
    picture: RgbPicture, face: Face, region: str, light: SceneLight
) -> np.ndarray | None:
    """The input of a region's net from a picture, (H, W, 3) uint8.

    None when the region cannot be seen.
    """
    places = input_places(face, region)
    if places is None:
        return None
    return net_input(picture.crop(*crop_around(face, region)), places, light)


def divide_light(rgb8: np.ndarray, light: SceneLight) -> np.ndarray:
    """Colours (..., 3) uint8 as they would appear in neutral light of full strength.

    So a product shows its own colour, whatever the light of the photo. Colours that would be too
    bright become white. In and out: R'G'B' as sRGB encodes it.
    """
    table = to_encoded(neutral_table(light), SRGB).clip(0, 1)
    divided: np.ndarray = cv2.LUT(rgb8, np.rint(255 * table).astype(np.uint8)[None])
    return divided


def to_targets(values: np.ndarray) -> np.ndarray:
    """NUMBERS (..., 7) -> targets of a net (..., 7), about 0 to 1."""
    targets = np.asarray(values, np.float64) / _UNITS
    # the step from no gloss to a little is easier to see than an equal step further up
    targets[..., _GLOSS] = np.sqrt(targets[..., _GLOSS])
    return targets


def from_targets(targets: np.ndarray) -> np.ndarray:
    """Targets of a net (..., 7) -> NUMBERS (..., 7), limited to the ranges of the training."""
    values: np.ndarray = np.clip(np.asarray(targets, np.float64), 0, 1)
    values[..., _GLOSS] **= 2
    return values * _UNITS


def read_numbers(net: Callable[[np.ndarray], np.ndarray], rgb8: np.ndarray) -> np.ndarray:
    """(7,) the NUMBERS that a net reads from its input (H, W, 3) uint8.

    They are the mean over the input and its mirror image, which show the same makeup.
    net: inputs (N, H, W, 3) -> targets (N, 7).
    """
    return from_targets(net(np.stack([rgb8, rgb8[:, ::-1]])).mean(0))
