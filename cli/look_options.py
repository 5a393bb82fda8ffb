"""The options of `apply` and `live` that say what to paint, on whom, and on which device."""

from dataclasses import dataclass, field, make_dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer
from makeup_video.cli.console import log
from makeup_video.cli.options import COLOUR, FACES, LOOK, RUN, RefPhoto
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.params import hex_of

_FACES = {
    word: name
    for name, words in {
        "all": ("all", "any", "both", "every", "everybody", "everyone"),
        "largest": ("largest", "biggest", "closest", "main", "nearest"),
    }.items()
    for word in words
}

if TYPE_CHECKING:
    from makeup_video.pipeline import Look
    from makeup_video.pipeline.look.kinds.kind import Kind
    from makeup_video.pipeline.look.options import Choice


LOOK_HELP = (
    "A look file (JSON) or, where no such file exists, a ready look (`makeup-video looks` lists "
    "them); 'none' paints nothing"
)


def faces_meant(value: str | None) -> str | None:
    """The standard word for a word about faces: "biggest" gives "largest"; other words stay."""
    return None if value is None else _FACES.get(value.strip().lower(), value)


def ready_names(incomplete: str) -> list[str]:
    """The ready looks whose names begin with `incomplete`, for a shell that completes a line."""
    from makeup_video.pipeline import ready_looks

    return [one.name for one in ready_looks() if one.name.startswith(incomplete)]


@dataclass(frozen=True, kw_only=True)
class _WholeLook:
    """The options that give a whole look, which other options change."""

    ref: RefPhoto = None
    look: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help=f"{LOOK_HELP}.",
            autocompletion=ready_names,
            rich_help_panel=LOOK,
        ),
    ] = None


def _help_of_part(kind: "Kind") -> str:
    """The help text of a part's option, with an example that has every word this kind takes."""
    slot = next((dial.default for dial in kind.dials if dial.name == "slot"), None)
    words = [hex_of(kind.first_rgb), kind.first_finish, *([slot, "80%"] if slot else [])]
    layers = f"; up to {kind.most} layers, separated by commas" if kind.most > 1 else ""
    return f"{kind.product}, as in '{':'.join(words)}', or 'none'{layers}."


def _part_option(kind: "Kind") -> tuple[str, Any, Any]:
    """The field of a dataclass for the option of a part: its name, type and default."""
    option = typer.Option(
        metavar=f"{COLOUR}[:WORD]", help=_help_of_part(kind), rich_help_panel=LOOK
    )
    return kind.part, Annotated[str | None, option], field(default=None)


def with_parts(whole: type) -> type:
    """A dataclass with the options of `whole` and an option for every part."""
    parts = map(_part_option, PARTS.values())
    return make_dataclass(
        f"{whole.__name__}Parts", parts, bases=(whole,), frozen=True, kw_only=True
    )


# A name in braces, such as {finishes}, stands for the names of a table. Only a help page loads the
# tables, since loading them would cost every other command 20 ms.
@dataclass(frozen=True, kw_only=True)
class Changes:
    """Options that change a look, choose the faces to paint and choose the device, as typed."""

    color: Annotated[
        str | None,
        typer.Option(
            metavar=COLOUR,
            help="A colour for the lips, for lips and eyes of a look, or for --parts: '#B4002E', "
            "B4002E, darkred.",
            rich_help_panel=LOOK,
        ),
    ] = None
    finish: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="The finish of parts that are given without one: {finishes}.",
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
            help="Where the eyeshadow goes, in a look with one eyeshadow: {zone}.",
            rich_help_panel=LOOK,
        ),
    ] = None
    intensity: Annotated[
        str | None,
        typer.Option(metavar="0..1", help="Strength of the eyeshadow.", rich_help_panel=LOOK),
    ] = None
    strength: Annotated[
        str | None,
        typer.Option(
            metavar="0..1", help="Strength of the whole look; or 70%.", rich_help_panel=LOOK
        ),
    ] = None
    faces: Annotated[
        str,
        typer.Option(
            metavar="FACE",
            help="Which faces to paint: all, largest, or the number of one as inspect shows it.",
            callback=faces_meant,
            rich_help_panel=FACES,
        ),
    ] = "all"
    ref_face: Annotated[
        str | None,
        typer.Option(
            metavar="FACE",
            help="Which face of PHOTO to read: largest, or its number as inspect shows it.",
            callback=faces_meant,
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

    @property
    def worn(self) -> dict[str, str]:
        """The texts given to the options of the parts, by part."""
        texts = {part: getattr(self, part) for part in PARTS}
        return {part: text for part, text in texts.items() if text is not None}

    def choice(self) -> "Choice":
        """The options that change the look of --look or --ref."""
        from makeup_video.pipeline.look.options import Choice

        return Choice(
            worn=self.worn,
            color=self.color,
            finish=self.finish,
            parts=self.parts,
            zone=self.zone,
            intensity=self.intensity,
            strength=self.strength,
        )

    @property
    def gives_makeup(self) -> bool:
        """Whether options give makeup to paint even if the photo shows none."""
        return self.color is not None or bool(self.worn)


@dataclass(frozen=True, kw_only=True)
class LookOptions(Changes, with_parts(_WholeLook)):  # type: ignore[misc]
    """The options of a command that paints one look, with an option for every part."""

    def base_look(self, quiet: bool) -> "Look | None":
        """The look of --look or --ref; None when neither was given.

        The look of a photo is logged in one line, unless quiet. Raises UsageError, LookError,
        InputError, PhotoError.
        """
        from makeup_video.pipeline.look.ready import load_look

        check_sources(self.look, self.ref)
        if self.ref is not None:
            return look_of_photo(self.ref, self.ref_face or "", self.gives_makeup, quiet)
        check_ref_face(self.ref_face, self.ref)
        if self.look is None:
            return None
        return load_look(self.look)


def check_sources(look: str | None, ref: str | None) -> None:
    """Raises UsageError when both options are given, since only one look is painted."""
    from makeup_video.pipeline import UsageError

    if look is not None and ref is not None:
        raise UsageError("--look and --ref both give a look: leave one of them out")


def check_ref_face(face: str | None, photo: str | list[str] | None) -> None:
    """Raises UsageError when a face is chosen but no photo is given."""
    from makeup_video.pipeline import UsageError

    if face is not None and not photo:
        raise UsageError("--ref-face chooses a face of the photo: add --ref PHOTO, or leave it out")


def check_photo(photo: str) -> None:
    """Raises UsageError when a look is given in place of a photo."""
    from makeup_video.pipeline import UsageError
    from makeup_video.pipeline.look.ready import is_file

    if photo.lower().endswith(".json") or not is_file(photo):
        raise UsageError(f"--ref takes a photo, and {photo} is a look: use --look {photo}")


def look_of_photo(photo: str, face: str, may_be_bare: bool, quiet: bool) -> "Look":
    """The look of a photo. Unless quiet, one line logs the look and how certain it is.

    Raises UsageError, InputError, PhotoError.
    """
    from makeup_video.pipeline import PhotoError
    from makeup_video.pipeline.engine.machine import seek_garbage
    from makeup_video.pipeline.reference.estimate import estimate_from

    seek_garbage()
    check_photo(photo)
    read = estimate_from(photo, face)
    if read.look.is_bare and not may_be_bare:
        raise PhotoError(
            f"{photo}: no makeup was found to paint: add --color '#B4002E', or give another photo"
        )
    if not quiet:
        log(f"{photo}: {read.in_words()}")
    return read.look


def log_changes(read: "Look", painted: "Look") -> None:
    """Log the painted look in one line if options changed the look that was read."""
    from makeup_video.pipeline.look.finishes import look_in_words

    if painted != read:
        log(f"painted: {look_in_words(painted, with_bare=False)}")
