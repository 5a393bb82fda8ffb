"""The look in a photo that a page sent; the reasons why there is none are told to a visitor."""

from makeup_video.pipeline.errors import PhotoError
from makeup_video.pipeline.look.look import Look
from makeup_video.web.read_apart import read_apart


def read_look(photo: bytes, name: str) -> Look:
    """The makeup of the only face, passers-by in the background aside; messages call the photo `name`.

    Raises PhotoError, InputError.
    """
    from makeup_video.pipeline import look_from_photo

    look = look_from_photo(photo, name=name, read=read_apart)
    if look.is_bare:
        raise PhotoError(f"{name}: no makeup was found to paint: give another photo")
    return look
