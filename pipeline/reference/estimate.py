"""Reads a look from a photo: photo -> face -> crops of lips and eyes -> seven numbers each -> Look.

The crops are cut, and the light on the face is divided out of them, exactly as for the pictures
that the nets were trained on (`reference_io`). The renderer's other ten settings are those of the
finish that the seven numbers come nearest to. A lipstick's colour gets a second look.
"""

import math
import os
from collections.abc import Callable, Sequence
from functools import cache

import cv2
import numpy as np
from makeup_video.pipeline.crop import RgbPicture, check_rgb8
from makeup_video.pipeline.errors import PhotoError, SeveralFacesError, UsageError
from makeup_video.pipeline.face import Face, FrameFaces, iod_px, resized
from makeup_video.pipeline.faces import find_faces, lip_mask
from makeup_video.pipeline.finishes import FINISHES, nearest_finish
from makeup_video.pipeline.light import light_of
from makeup_video.pipeline.look import GraphicsParams, Look
from makeup_video.pipeline.memory import READ_PHOTO, check_memory, give_back_memory
from makeup_video.pipeline.net import Net, read_array
from makeup_video.pipeline.photo import read_photo
from makeup_video.pipeline.reference_io import NUMBERS, numbers_told, read_crop
from makeup_video.pipeline.scene import SceneLight
from makeup_video.pipeline.second_look import second_look
from makeup_video.pipeline.still import to_frame
from makeup_video.pipeline.topology import EYE, EYE_CORNERS, FACE_OVAL, LIPS, RIGHT_EYE

THREADS = 2  # of each net; a photo is read once, before the film needs the cores
MIN_WIDTH_PX = 100  # of the face
MAX_TURN_DEGREES = 40
# Others are somebody in the background when they are narrower than this part of the largest face.
BYSTANDER = 0.4
# A face whose red, green and blue differ less than this (8-bit codes, on average) is a grey one.
GREY_CODES = 4.0
# The median of a face's brightest channel: below, what a camera adds outweighs what it saw. Of portraits in
# poor light it is 45 and more.
DARK_CODES = 25
# Where two channels end at white, the hue is lost. Of ordinary lips that is 0.04 at most, shine included.
LOST_CODE, MOST_LOST = 254, 0.2
# So many of a region's points lie in the picture when no more than its rim is cut off.
_NEARLY_ALL = 0.9
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
    has_eyes = _is_inside(rgb8, face, [*EYE, *RIGHT_EYE])
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
            f"--ref-face must be largest, or the number that inspect shows, got {face!r}"
        )
    check_memory(READ_PHOTO)
    rgb8 = read(photo, name) if read and isinstance(photo, bytes) else read_photo(photo, name)
    try:
        return estimate_look(rgb8, choose_face(find_faces(rgb8), chosen))
    except PhotoError as error:
        raise type(error)(f"{name if isinstance(photo, bytes) else photo}: {error}") from None
    finally:
        # what is painted next does not need these nets, nor their 80 MB; loading them takes 0.1 s
        _net.cache_clear()
        give_back_memory()


def choose_face(faces: Sequence[Face], chosen: str = "") -> Face:
    """The one that is meant, of faces that are sorted by size; `chosen` as in look_from_photo.

    Much smaller ones in the background are nobody's. Raises PhotoError.
    """
    if not faces:
        raise PhotoError(
            "no face was found: give a photo that shows one upright and from the front, larger or "
            "brighter"
        )
    if chosen.isdigit():
        for face in faces:
            if face.track_id == int(chosen):
                return face
        raise PhotoError(f"there is no face {chosen}; there are {_list(faces)}: choose one of them")
    rivals = [one for one in faces if width_px(one) > BYSTANDER * width_px(faces[0])]
    if len(rivals) > 1 and chosen != "largest":
        raise SeveralFacesError(
            f"one face was expected, {len(rivals)} were found: choose with --ref-face NUMBER or "
            f"--ref-face largest; there are {_list(rivals)}"
        )
    return faces[0]


def check_face(rgb8: np.ndarray, face: Face) -> None:
    """Raises PhotoError when makeup cannot be read from this face."""
    if width_px(face) < MIN_WIDTH_PX:
        raise PhotoError(
            f"the face is {width_px(face):.0f} px wide, and at least {MIN_WIDTH_PX} px are needed: "
            "give a larger photo, or one from closer"
        )
    if (turn := turn_degrees(face)) > MAX_TURN_DEGREES:
        raise PhotoError(
            f"the face is turned by {turn:.0f} degrees, and at most {MAX_TURN_DEGREES} are read: "
            "give a photo that shows it more from the front"
        )
    if face.mouth_weight < 1 or not _is_inside(rgb8, face, LIPS):
        raise PhotoError(
            "the mouth is covered, cut off, or cannot be seen well: give a photo that shows the lips"
        )
    if np.median(_sample(rgb8, face).max(1)) < DARK_CODES:
        raise PhotoError("the face is too dark to tell its colours: give a brighter photo")
    if _colourfulness(rgb8, face) < GREY_CODES:
        raise PhotoError("the photo is grey, without colours: give a colour photo")
    if _lost_share(rgb8, face) > MOST_LOST:
        raise PhotoError(
            "the lips are overexposed, and their colour is lost: give a photo with less light on them"
        )


def photo_light(rgb8: np.ndarray, face: Face) -> SceneLight:
    """The light on a face, read from all of the photo."""
    h, w = rgb8.shape[:2]
    scale = min(1.0, _LIGHT_IOD_PX / iod_px(face), math.sqrt(_LIGHT_PX / (h * w)))
    size_wh = max(1, round(scale * w)), max(1, round(scale * h))
    small = cv2.resize(rgb8, size_wh, interpolation=cv2.INTER_AREA) if scale < 1 else rgb8
    frame = to_frame(np.ascontiguousarray(small[..., ::-1]))
    return light_of(FrameFaces(frame, (resized(face, scale, scale),)))[0]


def width_px(face: Face) -> float:
    """Of the face, upright: between the outermost points of its oval, along the eyes."""
    across = face.points_px[EYE_CORNERS[1], :2] - face.points_px[EYE_CORNERS[0], :2]
    along = face.points_px[FACE_OVAL, :2] @ across / max(math.hypot(*across.tolist()), 1e-9)
    return float(np.ptp(along))


def turn_degrees(face: Face) -> float:
    """How far a head is turned from the viewer, to a side, up or down; tilting it is no turn.

    By the rotation that brings the mean face closest to its points (Kabsch 1976): the angle
    between where the nose points and the viewer.
    """
    mean = _mean_face()
    points = face.points_px.astype(np.float64)
    u, _, vt = np.linalg.svd((mean - mean.mean(0)).T @ (points - points.mean(0)))
    sign = np.sign(np.linalg.det(u @ vt))
    forward = u[2] @ np.diag([1, 1, sign]) @ vt
    return math.degrees(math.acos(min(max(float(forward[2]), -1.0), 1.0)))


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


def _is_inside(rgb8: np.ndarray, face: Face, points: Sequence[int] | np.ndarray) -> bool:
    """Nearly all of these points lie in the picture."""
    xy = face.points_px[np.asarray(points), :2]
    inside = ((xy > -0.5) & (xy < np.array(rgb8.shape[1::-1]) - 0.5)).all(1)
    return bool(inside.mean() > _NEARLY_ALL)


@cache
def _net(region: str) -> Net:
    return Net(f"reference_{region}", threads=THREADS)


@cache
def _mean_face() -> np.ndarray:
    return read_array("mean_face.npy").astype(np.float64)


def _sample(rgb8: np.ndarray, face: Face) -> np.ndarray:
    """(N, 3) some thousand pixels of the box around a face."""
    size = np.array(rgb8.shape[1::-1])
    low = np.clip(face.points_px[:, :2].min(0), 0, size - 1).astype(int)
    high = np.clip(face.points_px[:, :2].max(0), low + 1, size).astype(int)
    part = rgb8[low[1] : high[1], low[0] : high[0]]
    step = max(1, min(part.shape[:2]) // 64)
    return part[::step, ::step].reshape(-1, 3)


def _colourfulness(rgb8: np.ndarray, face: Face) -> float:
    """How far a pixel's largest channel lies above its smallest, on average over the face's box."""
    return float(np.ptp(_sample(rgb8, face).astype(np.float64), axis=1).mean())


def _lost_share(rgb8: np.ndarray, face: Face) -> float:
    """How much of the lips has two or three channels at white."""
    lips = rgb8[lip_mask(rgb8, face) > 0.5]
    return float(((lips >= LOST_CODE).sum(1) >= 2).mean()) if len(lips) else 0.0


def _list(faces: Sequence[Face]) -> str:
    """'0 at (120, 300), 210 px wide; ...'."""
    told = []
    for face in faces:
        x, y = face.points_px[:, :2].mean(0)
        told.append(f"{face.track_id} at ({x:.0f}, {y:.0f}), {width_px(face):.0f} px wide")
    return "; ".join(told)
