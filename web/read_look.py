"""Reads the look in a photo that a page sent, with messages for its visitor."""

from makeup_video.pipeline.errors import PhotoError
from makeup_video.pipeline.look.look import Look
from makeup_video.web.read_apart import read_apart


def read_look(photo: bytes, name: str) -> Look:
    """Read the makeup of the only face, apart from small ones in the background.

    name: what messages call the photo. Raises PhotoError, InputError.
    """
    from makeup_video.pipeline import look_from_photo

    look = look_from_photo(photo, name=name, read=read_apart)
    if look.is_bare:
        raise PhotoError(f"{name}: no makeup was found to paint: give another photo")
    return look
