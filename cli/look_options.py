"""The options that several commands say a look with, and the look that they mean before colours and finishes."""

import re
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.console import say
from makeup_video.pipeline.look.regions import REGIONS

if TYPE_CHECKING:
    from makeup_video.pipeline import Look


def parse_time(text: str, option: str) -> Fraction:
    """Seconds, exact, from '12.5', '1:02.5' or '0:01:02.5'. Raises UsageError."""
    from makeup_video.pipeline import UsageError

    if not re.fullmatch(r"(\d{1,9}:){0,2}\d{1,9}(\.\d{1,9})?", text, re.ASCII):
        raise UsageError(f"{option} must be seconds or [hh:]mm:ss[.fraction], got {text!r}")
    values = [Fraction(part) for part in text.split(":")]
    if any(value >= 60 for value in values[1:]):
        raise UsageError(f"{option} has a part of 60 or more after a colon: {text!r}")
    return sum((v * 60**i for i, v in enumerate(reversed(values))), Fraction(0))


LookFile = Annotated[
    str | None, typer.Option(metavar="FILE", help="A look file (JSON), or 'none'.")
]
Color = Annotated[
    str | None, typer.Option(metavar="HEX", help="The product's colour, such as '#B4002E'.")
]
Finish = Annotated[
    str | None, typer.Option(help="matte, satin, sheer, gloss, metallic or shimmer.")
]
Parts = Annotated[
    str | None,
    typer.Option(
        help=f"{', '.join(REGIONS)}, or several: lips,eyes; default: those of the look, lips."
    ),
]
Zone = Annotated[str | None, typer.Option(help="Of eye-shadow: lid, crease, full or outer.")]
Intensity = Annotated[float | None, typer.Option(metavar="0..1", help="How much eye-shadow.")]
Strength = Annotated[float | None, typer.Option(metavar="0..1", help="How much of all of it.")]
Faces = Annotated[str, typer.Option(help="all, largest, or a face's number as inspect shows it.")]
OpenclDevice = Annotated[
    str, typer.Option(help="The OpenCL device: a number or part of a name; default: the CPU.")
]
RefPhoto = Annotated[
    str | None, typer.Option(metavar="PHOTO", help="A photo of the makeup to paint.")
]
RefFace = Annotated[
    str | None, typer.Option(help="Whose makeup: largest, or a number as inspect shows it.")
]


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
    from makeup_video.pipeline.look.finishes import look_in_words

    look = look_from_photo(ref, face)
    if look.is_bare and color is None:
        raise PhotoError(
            f"{ref}: no makeup was found to paint: add --color '#B4002E', or give another photo"
        )
    if not quiet:
        say(f"{ref}: {look_in_words(look)}")
    return look
