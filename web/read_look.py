"""Reads the look in a photo that a page sent, with messages for its visitor."""

from typing import TYPE_CHECKING

from makeup_video.pipeline.errors import PhotoError
from makeup_video.web.read_apart import read_apart

if TYPE_CHECKING:
    from makeup_video.pipeline.reference.estimate import Estimate


def read_look(photo: bytes, name: str) -> "Estimate":
    """Read the makeup of the only face, apart from small ones in the background.

    name: what messages call the photo. Raises PhotoError, InputError.
    """
    from makeup_video.pipeline.engine.machine import FIND_FACES, check_memory

    check_memory(FIND_FACES)  # with less, the libraries of the nets crash while they are loaded
    from makeup_video.pipeline.reference.estimate import estimate_photo

    read = estimate_photo(photo, name=name, read=read_apart)
    if read.look.is_bare:
        raise PhotoError(
            f"{name}: nothing is worn, or too little to see: give a photo with more makeup"
        )
    return read
