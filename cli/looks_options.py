"""The options of `apply` and `batch` that say which looks to paint: one, or several."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.console import log
from makeup_video.cli.look_options import (
    LOOK_HELP,
    Changes,
    check_photo,
    check_ref_face,
    log_changes,
    look_of_photo,
    ready_names,
    with_parts,
)
from makeup_video.cli.options import LOOK
from makeup_video.cli.outcome import some_of

if TYPE_CHECKING:
    from makeup_video.pipeline import Look
    from makeup_video.pipeline.look.named import NamedLook


@dataclass(frozen=True, kw_only=True)
class _WholeLooks:
    """The options that give whole looks, each painted into an output of its own."""

    ref: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PHOTO",
            help="A photo of the makeup to paint; may be given several times.",
            rich_help_panel=LOOK,
        ),
    ] = None
    look: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help=f"{LOOK_HELP}; may be given several times.",
            autocompletion=ready_names,
            rich_help_panel=LOOK,
        ),
    ] = None
    looks: Annotated[
        str | None,
        typer.Option(
            metavar="FOLDER",
            help="Every look file of a folder, or every photo where it has none, or what a pattern "
            "such as 'looks/*.json' matches.",
            rich_help_panel=LOOK,
        ),
    ] = None
    catalogue: Annotated[
        str | None,
        typer.Option(
            metavar="CSV",
            help="A look for every row of a catalogue with the columns brand, product, shade, hex.",
            rich_help_panel=LOOK,
        ),
    ] = None
    where: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COLUMN=VALUE",
            help="Only the rows of the catalogue with this value, as in 'brand=X'; may be given "
            "several times.",
            rich_help_panel=LOOK,
        ),
    ] = None


@dataclass(frozen=True)
class WantedLook:
    """A look that the options ask for.

    fields: the values of the look for a template of outputs: its name, and more for some looks.
    load(quiet): reads the look; the look of a photo is logged in one line, unless quiet.
    check(): raises the errors of `load` that can be found without reading a photo.
    where: the file and line of a catalogue's row; "" for other looks.
    """

    fields: dict[str, str]
    load: "Callable[[bool], Look]"
    check: "Callable[[], object]"
    where: str = ""

    @property
    def called(self) -> str:
        """What messages call the look."""
        return self.where or self.fields.get("look", "")


def _at_once(fields: dict[str, str], read: "Callable[[], Look]", where: str = "") -> WantedLook:
    """A look from no photo: it is read only once, when it is first checked or loaded."""
    once = cache(read)
    return WantedLook(fields, lambda quiet: once(), once, where)


def _parts_of(row: "NamedLook") -> set[str]:
    """The parts that a catalogue's row gives."""
    from makeup_video.pipeline.look.kinds import KINDS

    return {KINDS[layer.kind].part for layer in row.look.layers}


@dataclass(frozen=True, kw_only=True)
class LooksOptions(Changes, with_parts(_WholeLooks)):  # type: ignore[misc]
    """The options of a command that paints one look or several."""

    @property
    def files(self) -> list[str]:
        """The files that the looks are read from."""
        from makeup_video.pipeline.look.ready import is_file

        files = [name for name in self.look or [] if is_file(name)]
        folder = map(str, self._in_folder())
        return [*files, *(self.ref or []), *folder, *filter(None, [self.catalogue])]

    @property
    def takes_off(self) -> list[str]:
        """The options, as they are typed, that may leave a look without makeup."""
        from makeup_video.pipeline.look.words import is_none

        bared = [part for part, text in self.worn.items() if is_none(text)]
        return [f"--{name}" for name in (*(["parts"] if self.parts else []), *bared)]

    def wanted(self, quiet: bool = False) -> list[WantedLook]:
        """All looks, in the order --look, --ref, --looks, --catalogue; equal names get numbers.

        Photos are read only by `load`. Rows of the catalogue that are left out are logged, unless
        quiet. Raises UsageError, LookError, CatalogueError.
        """
        from makeup_video.pipeline.look.named import numbered
        from makeup_video.pipeline.look.options import check_options

        self._check()
        check_options(self.choice())
        found = [*self._named(), *self._rows(quiet)] or [_at_once({}, lambda: self._painted(None))]
        names = numbered([one.fields.get("look", "") for one in found])
        return [
            replace(one, fields=one.fields | {"look": name})
            for one, name in zip(found, names, strict=True)
        ]

    def _check(self) -> None:
        from makeup_video.pipeline import UsageError
        from makeup_video.pipeline.look.named import is_photo

        if self.ref_face is not None:
            photos = [str(path) for path in self._in_folder() if is_photo(path)]
            check_ref_face(self.ref_face, [*(self.ref or []), *photos])
        if self.catalogue is None and self.where:
            raise UsageError("--where chooses rows of a catalogue: add --catalogue CSV")
        if self.catalogue is not None and self.color is not None:
            raise UsageError("--catalogue and --color both give the colour: leave one of them out")

    def _named(self) -> Iterator[WantedLook]:
        """The looks of files, ready looks and photos."""
        from makeup_video.pipeline.look.named import is_photo

        yield from map(self._of_file, self.look or [])
        yield from map(self._of_photo, self.ref or [])
        for path in self._in_folder():
            yield self._of_photo(str(path)) if is_photo(path) else self._of_file(str(path))

    def _in_folder(self) -> list[Path]:
        """The look files and photos that --looks finds."""
        from makeup_video.pipeline.look.named import look_files

        return [] if self.looks is None else look_files(self.looks)

    def _of_file(self, name: str) -> WantedLook:
        return _at_once({"look": Path(name).stem}, partial(self._load, name))

    def _of_photo(self, photo: str) -> WantedLook:
        fields = {"look": Path(photo).stem}
        return WantedLook(fields, partial(self._read, photo), partial(check_photo, photo))

    def _load(self, name: str) -> "Look":
        from makeup_video.pipeline.look.ready import load_look

        return self._painted(load_look(name))

    def _read(self, photo: str, quiet: bool) -> "Look":
        base = look_of_photo(photo, self.ref_face or "", self.gives_makeup, quiet)
        painted = self._painted(base)
        if not quiet:
            log_changes(base, painted)
        return painted

    def _rows(self, quiet: bool) -> Iterator[WantedLook]:
        """The looks of the catalogue's rows."""
        from makeup_video.pipeline.look.finishes import parse_finish
        from makeup_video.pipeline.look.kinds import PARTS
        from makeup_video.pipeline.look.named import looks_of_catalogue
        from makeup_video.pipeline.look.options import parse_parts

        if self.catalogue is None:
            return
        finish = None if self.finish is None else parse_finish(self.finish)
        parts = () if self.parts is None else parse_parts(self.parts)
        others: Counter[str] = Counter()
        unknown: Counter[str] = Counter()
        found = looks_of_catalogue(
            self.catalogue,
            self.where or (),
            finish,
            parts,
            lambda kind: others.update([kind]),
            lambda kind: unknown.update([kind]),
        )
        if unknown and not quiet:
            log(
                f"{self.catalogue}: {unknown.total()} of {others.total() + len(found)} rows "
                f"painted on the {next(iter(PARTS))}, since their category names no part: "
                f"{some_of(list(unknown))}"
            )
        if others and not quiet:
            out, rows = others.total(), others.total() + len(found)
            log(
                f"{self.catalogue}: {out} of {rows} rows left out, since they are for no part that "
                f"is painted: {some_of(list(others))}"
            )
        self._check_worn(found, quiet)
        have_eyes = any(row.look.of("eyeshadow") for row in found)
        for row in found:
            yield _at_once(row.fields, partial(self._on_row, row, have_eyes), row.where)

    def _check_worn(self, rows: "Sequence[NamedLook]", quiet: bool) -> None:
        """Unless quiet, log the rows that keep their own part although an option gives it, too.

        Raises UsageError when every row gives that part: the option would change none of them.
        """
        from makeup_video.pipeline import UsageError

        for part in self.worn:
            own = [row.name for row in rows if part in _parts_of(row)]
            if len(own) == len(rows):
                raise UsageError(
                    f"{self.catalogue}: every row that is painted gives the {part}, and so does "
                    f"--{part}: leave --{part} out"
                )
            if own and not quiet:
                log(
                    f"{self.catalogue}: {len(own)} of {len(rows)} rows not changed by --{part}, "
                    f"since they are for the {part}: {some_of(own)}"
                )

    def _on_row(self, row: "NamedLook", have_eyes: bool) -> "Look":
        """The look of a row, changed by the other options; --parts was applied to it already.

        have_eyes: some row has eyeshadow, so options for eyeshadow leave the other rows alone.
        An option for the part that the row itself gives does not change it: otherwise all rows for
        this part would look alike.
        """
        from makeup_video.pipeline.look.options import choose_look

        worn = {part: text for part, text in self.worn.items() if part not in _parts_of(row)}
        choice = replace(self.choice(), base=row.look, parts=None, worn=worn)
        if not choice.worn:
            choice = replace(choice, finish=None)  # the row's look has this finish already
        if have_eyes and not row.look.of("eyeshadow") and "eyes" not in choice.worn:
            choice = replace(choice, zone=None, intensity=None)
        return choose_look(choice)

    def _painted(self, base: "Look | None") -> "Look":
        from makeup_video.pipeline.look.options import choose_look

        return choose_look(replace(self.choice(), base=base))
