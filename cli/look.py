"""The look that the options of a command mean, before colours and finishes on top of it."""

from typing import TYPE_CHECKING

from makeup_video.cli.say import say

if TYPE_CHECKING:
    from makeup_video.pipeline import Look


def base_look(
    look: str | None, ref: str | None, ref_face: str | None, color: str | None, quiet: bool
) -> "Look | None":
    """The look of --look or --ref, None when neither was given."""
    from makeup_video.pipeline import Look, UsageError

    if look is not None and ref is not None:
        raise UsageError("--look and --ref both give a look: leave one of them out")
    if ref is not None:
        return _look_of_photo(ref, ref_face or "", color, quiet)
    if ref_face is not None:
        raise UsageError("--ref-face chooses a face of the photo: add --ref PHOTO, or leave it out")
    if look is None:
        return None
    return Look() if look == "none" else Look.load(look)


def _look_of_photo(ref: str, face: str, color: str | None, quiet: bool) -> "Look":
    """The look of a photo, told in a line."""
    from makeup_video.pipeline import PhotoError, look_from_photo
    from makeup_video.pipeline.finishes import REGIONS, in_words

    look = look_from_photo(ref, face)
    if look.is_bare and color is None:
        raise PhotoError(
            f"{ref}: no makeup was found to paint: add --color '#B4002E', or give another photo"
        )
    worn = {name: getattr(look, name) for name in REGIONS}
    told = (f"{n} {p.hex}, {in_words(p, n)}" if p else f"{n} bare" for n, p in worn.items())
    if not quiet:
        say(f"{ref}: {'; '.join(told)}")
    return look
