"""Reads a look from a photo: photo -> face -> crops of lips and eyes -> seven numbers each -> Look.

The crops are cut, and the light on the face is divided out of them, exactly as for the pictures
that the nets were trained on (`reference_io`). The renderer's other ten settings are those of the
finish that the seven numbers come nearest to. A lipstick's colour gets a second look.
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
from makeup_video.pipeline.faces.topology import EYE, RIGHT_EYE
from makeup_video.pipeline.frames.rgb import to_frame
from makeup_video.pipeline.frames.views import RgbPicture, check_rgb8
from makeup_video.pipeline.images.photo_file import read_photo
from makeup_video.pipeline.look.finishes import FINISHES, nearest_finish
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.reference.checks import check_face, choose_face, is_inside
from makeup_video.pipeline.reference.correct_colour import second_look
from makeup_video.pipeline.reference.crops import NUMBERS, numbers_told, read_crop
from makeup_video.pipeline.render.scene import SceneLight
from makeup_video.pipeline.render.scene_light import light_of

THREADS = 2  # of each net; a photo is read once, before the film needs the cores
# More shine than this is hardly worn: pale lips in bright photos are taken for it, and come out frosted.
MOST_GLOSS, MOST_REFLECTION = 3.0, 0.35
# Below all three a region is bare: so little could not be told from skin.
BARE_OPACITY, BARE_GLOSS, BARE_REFLECTION = 0.2, 0.4, 0.2

# Light is read from a copy where the outer eye corners are this far apart, as in training, and
# that is no larger than this: where the eyes are 20 px apart, the light is still the same within 1 %.
_LIGHT_IOD_PX, _LIGHT_PX = 69, 1_000_000


def estimate_look(rgb8: np.ndarray, face: Face | None = None) -> Look:
    """The makeup that somebody wears in a photo; a region without any is None.

    rgb8: (H, W, 3) uint8, upright, R'G'B' as sRGB encodes it, any size; it is not changed.
    face: whose makeup, as `find_faces` found it in this very picture; None: the one there is.
    Colours are those of the product in neutral light, whatever the light of the photo. Eyes beyond
    the border of the picture are bare. zone, intensity and strength are a Look's defaults, for a
    photo does not tell them.

    Raises PhotoError when no look can be read, and says why: no face, several faces and none
    chosen, a face that is too small, turned too far, too dark or grey, a mouth that is covered,
    overexposed lips. ValueError
    for another shape or dtype, InstallError when the nets are missing.
    """
    check_rgb8(rgb8)
    face = choose_face(find_faces(rgb8)) if face is None else face
    check_face(rgb8, face)
    light = photo_light(rgb8, face)
    lips = _read(rgb8, face, light, "lips")
    has_eyes = is_inside(rgb8, face, [*EYE, *RIGHT_EYE])
    return Look(
        lips=lips and second_look(rgb8, face, light, lips),
        eyes=_read(rgb8, face, light, "eyes") if has_eyes else None,
    )


def look_from_photo(
    photo: str | os.PathLike[str] | bytes,
    face: int | str | None = None,
    *,
    name: str = "the photo",
    read: Callable[[bytes, str], np.ndarray] | None = None,
) -> Look:
    """The same from a file, or from the bytes of one, as `read_photo` reads it.

    name: how messages call a photo that comes as bytes; a file has its own.
    read: decodes such a photo in place of `read_photo`, given the bytes and the name.
    face: None or "" for the only one, "largest", or one by its number, 0 being the largest face.
    Raises PhotoError and InputError naming the file, UsageError for another `face`,
    TooLittleMemoryError.
    """
    chosen = "" if face is None else str(face)
    is_number = chosen.isascii() and chosen.isdigit() and len(chosen) < 10
    if chosen not in ("", "largest") and not is_number:
        raise UsageError(
            f"{option('face')} must be largest, or the number that inspect shows, got {face!r}"
        )
    check_memory(READ_PHOTO)
    rgb8 = read(photo, name) if read and isinstance(photo, bytes) else read_photo(photo, name)
    try:
        return estimate_look(rgb8, choose_face(find_faces(rgb8), chosen))
    except PhotoError as error:
        error.extend(before=f"{name if isinstance(photo, bytes) else photo}: ")
        raise
    finally:
        # what is painted next does not need these nets, nor their 80 MB; loading them takes 0.1 s
        _net.cache_clear()
        give_back_memory()


def photo_light(rgb8: np.ndarray, face: Face) -> SceneLight:
    """The light on a face, read from all of the photo."""
    h, w = rgb8.shape[:2]
    scale = min(1.0, _LIGHT_IOD_PX / iod_px(face), math.sqrt(_LIGHT_PX / (h * w)))
    size_wh = max(1, round(scale * w)), max(1, round(scale * h))
    small = cv2.resize(rgb8, size_wh, interpolation=cv2.INTER_AREA) if scale < 1 else rgb8
    frame = to_frame(np.ascontiguousarray(small[..., ::-1]))
    return light_of(FrameFaces(frame, (resized(face, scale, scale),)))[0]


def product_of(numbers: np.ndarray, region: str) -> GraphicsParams | None:
    """The net's seven numbers, as in a look -> the product; None when it is nothing to speak of."""
    product = product_with(numbers, region)
    is_bare = (
        product.opacity < BARE_OPACITY
        and product.gloss < BARE_GLOSS
        and product.reflection < BARE_REFLECTION
    )
    return None if is_bare else product


def product_with(numbers: np.ndarray, region: str) -> GraphicsParams:
    """(7,) numbers, and settings of the nearest finish that does not shimmer: the numbers do not tell
    shimmer, and sparkles that nobody wears look worse than some that are missing."""
    # a look is read by people: no more digits than the net can tell
    rounded = np.round(np.asarray(numbers, np.float64), 3)
    g = dict(zip(NUMBERS, rounded.tolist(), strict=True))
    g["gloss"] = min(g["gloss"], MOST_GLOSS)
    g["reflection"] = min(g["reflection"], MOST_REFLECTION)
    four = g["opacity"], g["gloss"], g["gloss_roughness"], g["reflection"]
    finish = nearest_finish(*four, region, shimmers=False)
    return GraphicsParams(**{**FINISHES[finish][region], **g})


def _read(rgb8: np.ndarray, face: Face, light: SceneLight, region: str) -> GraphicsParams | None:
    crop = read_crop(RgbPicture(rgb8), face, region, light)
    if crop is None:
        return None
    return product_of(numbers_told(lambda rgb8: _net(region)(rgb8)["targets"], crop), region)


@cache
def _net(region: str) -> Net:
    return Net(f"reference_{region}", threads=THREADS)
