"""Reads the look in a photo that a page sent, with messages for the visitor."""

from functools import cache
from pathlib import Path

import numpy as np
from makeup_video.pipeline.errors import PhotoError, SeveralFacesError
from makeup_video.pipeline.look.finishes import look_in_words
from makeup_video.pipeline.look.look import Look
from makeup_video.web.read_apart import read_apart
from makeup_video.web.session import PhotoLook, SeveralFaces
from makeup_video.web.small_picture import small_jpeg

_CHOICE_PX = 800  # longer side of the picture on which a face is chosen
_AROUND = 1.2  # side of a face's box, as a multiple of the extent of its points


def read_look(photo: bytes, name: str, face: str = "") -> PhotoLook | SeveralFaces:
    """Read the makeup of the only face in a photo; small faces in the background do not count.

    name: what messages call the photo.  face: the number of the face to read, if the visitor has
    chosen one. Returns SeveralFaces when the visitor must choose a face first.
    Raises PhotoError, InputError.
    """
    from makeup_video.pipeline.engine.machine import FIND_FACES, check_memory

    check_memory(FIND_FACES)  # with less memory, the libraries of the nets crash while they load
    from makeup_video.pipeline.reference.estimate import estimate_from

    decoded: list[np.ndarray] = []

    def read(data: bytes, called: str) -> np.ndarray:
        decoded.append(read_apart(data, called))
        return decoded[0]

    try:
        read_makeup = estimate_from(photo, face, name=name, read=read)
    except SeveralFacesError as error:
        return _choice(decoded[0], error)
    check_worn(read_makeup.look, name)
    small = small_jpeg(decoded[0])
    return PhotoLook(name, read_makeup.look, read_makeup.in_words(), lambda: small)


def check_worn(look: Look, name: str) -> Look:
    """Return the look of the photo `name`. Raises PhotoError when the look is bare."""
    if look.is_bare:
        raise PhotoError(
            f"{name}: nothing is worn, or too little to see: give a photo with more makeup"
        )
    return look


def look_of_file(path: str, look: Look) -> PhotoLook:
    """The look of `--ref`; the photo is read again when a page wants its thumbnail."""
    from makeup_video.pipeline.images.photo_file import read_photo

    def thumbnail() -> bytes:
        return small_jpeg(read_photo(path))

    return PhotoLook(Path(path).name, look, look_in_words(look), cache(thumbnail))


def _choice(rgb8: np.ndarray, error: SeveralFacesError) -> SeveralFaces:
    height, width = rgb8.shape[:2]
    boxes = {}
    for face in error.faces:
        points_px = face.points_px[:, :2]
        low, high = points_px.min(0), points_px.max(0)
        middle, half = (low + high) / 2, _AROUND * (high - low) / 2
        left, top = np.maximum(middle - half, 0) / (width, height)
        right, bottom = np.minimum(middle + half, (width, height)) / (width, height)
        boxes[face.track_id] = float(left), float(top), float(right - left), float(bottom - top)
    return SeveralFaces(small_jpeg(rgb8, _CHOICE_PX), boxes)
