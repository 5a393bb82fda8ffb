"""The options of `apply` and `live` that say what to paint, on whom, and on which device."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.console import log
from makeup_video.cli.options import FACES, LOOK, RUN, RefPhoto

if TYPE_CHECKING:
    from makeup_video.pipeline import Look
    from makeup_video.pipeline.look.options import Choice


# A name in braces, such as {finishes}, stands for the names of a table. Only a help page loads the
# tables, which would take every command 20 ms more.
@dataclass(frozen=True, slots=True, kw_only=True)
class LookOptions:
    """What to paint, on whom, and on which device, as typed."""

    ref: RefPhoto = None
    color: Annotated[
        str | None,
        typer.Option(
            metavar="HEX", help="The product's colour, such as '#B4002E'.", rich_help_panel=LOOK
        ),
    ] = None
    look: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="A look file (JSON), or 'none' to paint nothing.",
            rich_help_panel=LOOK,
        ),
    ] = None
    finish: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="{finishes}.",
            rich_help_panel=LOOK,
        ),
    ] = None
    parts: Annotated[
        str | None,
        typer.Option(
            metavar="PARTS",
            help="{parts}; default: those of the look, or {default_parts}.",
            rich_help_panel=LOOK,
        ),
    ] = None
    zone: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Where eye-shadow goes: {zone}.",
            rich_help_panel=LOOK,
        ),
    ] = None
    intensity: Annotated[
        float | None,
        typer.Option(metavar="0..1", help="How much eye-shadow.", rich_help_panel=LOOK),
    ] = None
    strength: Annotated[
        float | None,
        typer.Option(metavar="0..1", help="How much of the whole look.", rich_help_panel=LOOK),
    ] = None
    faces: Annotated[
        str,
        typer.Option(
            metavar="FACE",
            help="Whom to paint: all, largest, or a face's number as inspect shows it.",
            rich_help_panel=FACES,
        ),
    ] = "all"
    ref_face: Annotated[
        str | None,
        typer.Option(
            metavar="FACE",
            help="Whose makeup in PHOTO: largest, or a number as inspect shows it.",
            rich_help_panel=FACES,
        ),
    ] = None
    device: Annotated[
        str,
        typer.Option(
            metavar="DEVICE",
            help="The OpenCL device that paints: its number or part of its name; default: the CPU.",
            rich_help_panel=RUN,
        ),
    ] = ""

    def choice(self) -> "Choice":
        """The options that change the look of --look or --ref."""
        from makeup_video.pipeline.look.options import Choice

        return Choice(
            color=self.color,
            finish=self.finish,
            parts=self.parts,
            zone=self.zone,
            intensity=self.intensity,
            strength=self.strength,
        )

    def base_look(self, quiet: bool) -> "Look | None":
        """The look of --look or --ref, None when neither was given.

        The look of a photo is logged in one line, unless quiet. Raises UsageError, LookError,
        InputError, PhotoError.
        """
        from makeup_video.pipeline import Look, UsageError

        if self.look is not None and self.ref is not None:
            raise UsageError("--look and --ref both give a look: leave one of them out")
        if self.ref is not None:
            return _look_of_photo(self.ref, self.ref_face or "", self.color, quiet)
        if self.ref_face is not None:
            raise UsageError(
                "--ref-face chooses a face of the photo: add --ref PHOTO, or leave it out"
            )
        if self.look is None:
            return None
        return Look() if self.look == "none" else Look.load(self.look)


def _look_of_photo(photo: str, face: str, color: str | None, quiet: bool) -> "Look":
    from makeup_video.pipeline import PhotoError, look_from_photo
    from makeup_video.pipeline.look.finishes import look_in_words

    look = look_from_photo(photo, face)
    if look.is_bare and color is None:
        raise PhotoError(
            f"{photo}: no makeup was found to paint: add --color '#B4002E', or give another photo"
        )
    if not quiet:
        log(f"{photo}: {look_in_words(look)}")
    return look
