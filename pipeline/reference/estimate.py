"""Reads a look from a photo: photo -> face -> a crop of each region -> seven numbers each -> Look.

The crops are sampled, and the light on the face is divided out, exactly as in training (crops.py).
The other ten settings of a product are those of the finish nearest to the seven numbers. The colour
of a lipstick is corrected at the end (correct_colour.py).
"""

import math
import os
from collections.abc import Callable
from functools import cache

import cv2
import numpy as np
from makeup_video.pipeline.engine.machine import READ_PHOTO, check_memory, give_back_memory
from makeup_video.pipeline.errors import PhotoError, UsageError, option
from makeup_video.pipeline.faces.face import Face, FrameFaces, iod_px, resized
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.frames.rgb import to_frame
from makeup_video.pipeline.frames.views import RgbPicture, check_rgb8
from makeup_video.pipeline.images.photo_file import read_photo
from makeup_video.pipeline.look.finishes import FINISHES, nearest_finish
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.reference.checks import check_face, choose_face, is_inside
from makeup_video.pipeline.reference.correct_colour import correct_colour
from makeup_video.pipeline.reference.crops import CROPS, NUMBERS, read_input, read_numbers
from makeup_video.pipeline.render.scene import SceneLight
from makeup_video.pipeline.render.scene_light import light_of

THREADS = 2  # of each net; a photo is read once, before the film needs the cores
# More shine is hardly ever worn: the nets take pale lips in bright photos for it, and the lips
# would come out frosted.
MOST_GLOSS, MOST_REFLECTION = 3.0, 0.35
# Below all three a region is bare: so little makeup cannot be distinguished from skin.
BARE_OPACITY, BARE_GLOSS, BARE_REFLECTION = 0.2, 0.4, 0.2
# Light is read from a copy whose outer eye corners are this far apart, as in training, and that has
# no more pixels than this. With the eyes 20 px apart, the light is still the same within 1 %.
_LIGHT_IOD_PX, _LIGHT_PX = 69, 1_000_000
# By region: what is done to a product after it was read.
_CORRECTIONS = {"lips": correct_colour}


def estimate_look(rgb8: np.ndarray, face: Face | None = None) -> Look:
    """The makeup worn in a photo; a region without makeup is None.

    rgb8: (H, W, 3) uint8, upright, R'G'B' as sRGB encodes it, any size; it is not changed.
    face: whose makeup, as `find_faces` found the face in this very picture; None: the only face.
    Colours are those of the product in neutral light, whatever the light of the photo. Eyes beyond
    the border of the picture are bare. Shapes and strengths are defaults, because a photo does not
    show them.

    Raises PhotoError with the reason when no look can be read: no face, several faces and none
    chosen, a face that is too small, turned too far, too dark or grey, a mouth that is covered,
    overexposed lips. Raises ValueError for another shape or dtype, InstallError when the nets are
    missing.
    """
    check_rgb8(rgb8)
    face = choose_face(find_faces(rgb8)) if face is None else face
    check_face(rgb8, face)
    light = photo_light(rgb8, face)
    read = {part: _read(rgb8, face, light, part) for part in CROPS}
    worn = {part: product for part, product in read.items() if product is not None}
    return Look(Layer(PARTS[part].name, product) for part, product in worn.items())


def look_from_photo(
    photo: str | os.PathLike[str] | bytes,
    face: int | str | None = None,
    *,
    name: str = "the photo",
    read: Callable[[bytes, str], np.ndarray] | None = None,
) -> Look:
    """The makeup worn in a photo file, or in the bytes of one, as `read_photo` reads it.

    face: None or "" for the only face, "largest", or the number of a face, 0 being the largest.
    name: what messages call a photo that comes as bytes; a file has its own name.
    read: decodes a photo that comes as bytes in place of `read_photo`, given the bytes and the
    name. Raises PhotoError and InputError, which name the file, UsageError for another `face`, and
    TooLittleMemoryError.
    """
    chosen = "" if face is None else str(face)
    is_number = chosen.isascii() and chosen.isdigit() and len(chosen) < 10
    if chosen not in ("", "largest") and not is_number:
        raise UsageError(f"{option('face')} must be largest, or the number of a face, got {face!r}")
    check_memory(READ_PHOTO)
    rgb8 = read(photo, name) if read and isinstance(photo, bytes) else read_photo(photo, name)
    try:
        return estimate_look(rgb8, choose_face(find_faces(rgb8), chosen))
    except PhotoError as error:
        error.extend(before=f"{name if isinstance(photo, bytes) else photo}: ")
        raise
    finally:
        # Painting does not need these nets, nor their 80 MB; loading them again takes 0.1 s.
        _net.cache_clear()
        give_back_memory()


def photo_light(rgb8: np.ndarray, face: Face) -> SceneLight:
    """The light on a face, read from the whole photo."""
    h, w = rgb8.shape[:2]
    scale = min(1.0, _LIGHT_IOD_PX / iod_px(face), math.sqrt(_LIGHT_PX / (h * w)))
    size_wh = max(1, round(scale * w)), max(1, round(scale * h))
    small = cv2.resize(rgb8, size_wh, interpolation=cv2.INTER_AREA) if scale < 1 else rgb8
    frame = to_frame(np.ascontiguousarray(small[..., ::-1]))
    return light_of(FrameFaces(frame, (resized(face, scale, scale),)))[0]


def product_of(numbers: np.ndarray, region: str) -> GraphicsParams | None:
    """Seven numbers of a look -> the product; None when it would hardly show."""
    product = product_with(numbers, region)
    is_bare = (
        product.opacity < BARE_OPACITY
        and product.gloss < BARE_GLOSS
        and product.reflection < BARE_REFLECTION
    )
    return None if is_bare else product


def product_with(numbers: np.ndarray, region: str) -> GraphicsParams:
    """Seven numbers of a look -> the product, with the settings of the nearest finish.

    The finish never shimmers: the numbers do not cover shimmer, and sparkles that nobody wears look
    worse than missing ones.
    """
    # People read look files: write no more digits than the net can resolve.
    rounded = np.round(np.asarray(numbers, np.float64), 3)
    g = dict(zip(NUMBERS, rounded.tolist(), strict=True))
    g["gloss"] = min(g["gloss"], MOST_GLOSS)
    g["reflection"] = min(g["reflection"], MOST_REFLECTION)
    shine = g["opacity"], g["gloss"], g["gloss_roughness"], g["reflection"]
    finish = nearest_finish(*shine, region, shimmers=False)
    return GraphicsParams(**{**FINISHES[finish][region], **g})


def _read(rgb8: np.ndarray, face: Face, light: SceneLight, region: str) -> GraphicsParams | None:
    """The product of a region; None when the region is bare or cannot be seen."""
    needed = CROPS[region].needed
    if needed and not is_inside(rgb8, face, needed):
        return None
    crop = read_input(RgbPicture(rgb8), face, region, light)
    if crop is None:
        return None
    numbers = read_numbers(lambda rgb8: _net(region)(rgb8)["targets"], crop)
    product = product_of(numbers, region)
    if product is not None and region in _CORRECTIONS:
        product = _CORRECTIONS[region](rgb8, face, light, product)
    return product


@cache
def _net(region: str) -> Net:
    return Net(f"reference_{region}", threads=THREADS)
