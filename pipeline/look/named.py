"""Looks with names, for videos that are painted in several looks: from files or catalogue rows."""

import glob
import os
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from makeup_video.pipeline.errors import CatalogueError, LookError, UsageError, option
from makeup_video.pipeline.files.endings import PHOTOS
from makeup_video.pipeline.files.template import in_name
from makeup_video.pipeline.look.catalogue import Row, rows_of
from makeup_video.pipeline.look.finishes import FINISHES, product
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.look.words import did_you_mean, finish_names, finish_of

_LOOK_FILES = ".json"
_MOST_NAMES = 5  # in a message


@dataclass(frozen=True, slots=True)
class NamedLook:
    """A look and its name in the names of outputs.

    brand, shade, product: from a catalogue's row, else empty.  where: the row's file and line.
    """

    name: str
    look: Look
    brand: str = ""
    shade: str = ""
    product: str = ""
    where: str = ""

    @property
    def fields(self) -> dict[str, str]:
        """The values of a template's fields."""
        row = {"brand": self.brand, "product": self.product, "shade": self.shade}
        return {"look": self.name, **row}


def look_files(place: str) -> list[Path]:
    """The look files of a folder, or the files that match a pattern such as looks/*.json, by name.

    A folder without look files gives its photos. In a folder with look files photos do not count:
    the looks were read from them, or they were painted with the looks. Hidden files of a folder,
    such as macOS writes beside others (._red.json), never count. Raises LookError where no file is
    found.
    """
    if os.path.isdir(place):
        try:
            found = [path for path in Path(place).iterdir() if _is_look(path)]
        except OSError as error:
            raise LookError(
                f"{place} cannot be read: {error.strerror}; allow it, or give another folder"
            ) from error
        if not found:
            raise LookError(
                f"{place} has no look files and no photos: give a folder with NAME{_LOOK_FILES} or "
                "photos of makeup"
            )
        return sorted([path for path in found if not is_photo(path)] or found)
    exists = os.path.lexists(place)  # its name may have brackets
    matching = map(Path, [place] if exists else glob.glob(place, recursive=True))
    found = sorted(path for path in matching if not path.is_dir())
    if not found:
        raise LookError(
            f"{place} is no folder, and no look file or photo matches it: check the path, or put a "
            "pattern into quotes"
        )
    return found


def is_photo(path: Path) -> bool:
    """Whether a file is a photo by the end of its name."""
    return path.suffix.lower() in PHOTOS


def _is_look(path: Path) -> bool:
    """False for hidden files and for folders."""
    is_one = path.suffix.lower() == _LOOK_FILES or is_photo(path)
    return is_one and not path.name.startswith(".") and not path.is_dir()


def looks_of_catalogue(
    path: str | os.PathLike[str],
    where: Sequence[str] = (),
    finish: str | None = None,
    parts: Sequence[str] = (),
    on_left_out: Callable[[str], object] = lambda kind: None,
    on_unknown: Callable[[str], object] = lambda kind: None,
) -> list[NamedLook]:
    """A look for each row of a catalogue: its colour and its finish on the part that it is for.

    where: conditions COLUMN=VALUE, all of which a row must meet; case does not matter.
    finish: the finish of all rows. None: the finish in the column `finish`, else the finish that
    the row's category names, else the first finish of the part.
    parts: the parts to paint; empty: every row counts. A row that may be for several parts is for
    the first of them in the order of PARTS.
    on_left_out: called with the category of each row whose product is for no part, such as mascara.
    on_unknown: called with the category of each row that goes to the first of all parts because no
    word of the category is known, such as a pencil.
    Raises UsageError for a condition, CatalogueError naming file, line and fault.
    """
    conditions = [_condition(text) for text in where]
    looks, others = [], Counter[str]()
    values: dict[str, Counter[str]] = {name: Counter() for name, _ in conditions}
    for row in rows_of(path):
        for name, value in conditions:
            if not _meets(row, name, value):
                values[name][row.cells[name]] += 1
                break
        else:
            fitting = [part for part in row.shade.parts if not parts or part in parts]
            if fitting:
                looks.append(_look_of(row, fitting[0], finish))
                if row.kind and len(fitting) == len(PARTS):
                    on_unknown(row.kind)
            elif not row.shade.parts:
                others[row.kind] += 1
                on_left_out(row.kind)
    if not looks:
        raise _nothing_found(path, where, parts, others, values)
    return looks


def _nothing_found(
    path: str | os.PathLike[str],
    where: Sequence[str],
    parts: Sequence[str],
    others: Counter[str],
    values: Mapping[str, Counter[str]],
) -> CatalogueError:
    """Why a catalogue gives no look.

    where, parts: see looks_of_catalogue.  others: the categories of products that are for no part.
    values: by column, the cells of rows that do not meet the condition on it.
    """
    if others and not parts:
        which = f" where {' and '.join(where)}" if where else ""
        return CatalogueError(
            f"{path} has only products that are not painted{which} ({_few(others)}): give some for "
            f"{', '.join(PARTS)}"
        )
    asked = [*where, *(f"{option('parts')} {part}" for part in parts)]
    if not asked:
        return CatalogueError(f"{path} has no row: give a catalogue with at least one")
    there = [f"; {name} is {_few(counts)}" for name, counts in values.items() if counts]
    return CatalogueError(
        f"{path} has no row that meets {' and '.join(asked)}{''.join(there)}: choose another one"
    )


def _few(names: Counter[str]) -> str:
    """The most frequent names, at most five."""
    shown = [name or "empty" for name, _ in names.most_common(_MOST_NAMES)]
    more = len(names) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")


def _condition(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise UsageError(f"{option('where')} must be COLUMN=VALUE, as in brand=X, got {text!r}")
    return name.strip().lower(), value.strip()


def _meets(row: Row, name: str, value: str) -> bool:
    if name not in row.cells:
        raise UsageError(
            f"{option('where')} names the column {name!r}, and the catalogue has "
            f"{', '.join(row.cells)}{did_you_mean(name, row.cells)}"
        )
    return row.cells[name].casefold() == value.casefold()


def _look_of(row: Row, part: str, finish: str | None) -> NamedLook:
    shade, written = row.shade, row.cells.get("finish", "")
    if finish is None and written:
        finish = finish_of(written)
        if finish is None:
            raise CatalogueError(
                f"{row.where}: finish must be one of {', '.join(FINISHES)}, or empty, got "
                f"{written[:40]!r}; {option('finish')} gives one to all rows"
                f"{did_you_mean(written, finish_names())}"
            )
    kind = PARTS[part]
    if finish is None:
        finish = _finish_in(row.kind) or kind.first_finish
    layer = Layer(kind.name, product(shade.rgb, finish, part))
    name = "-".join(filter(None, (shade.brand, shade.shade))) or "#" + bytes(shade.rgb).hex()
    return NamedLook(name, Look([layer]), shade.brand, shade.shade, shade.product, row.where)


def _finish_in(kind: str) -> str | None:
    """The finish that a category names, as in "Matt lipstick" or "Lipgloss"."""
    words = map(finish_of, re.split(r"[^a-z]+", kind))
    return next(filter(None, words), None) or next((one for one in FINISHES if one in kind), None)


def numbered(names: Sequence[str]) -> list[str]:
    """The names, with numbers where several would name the same file: nude, Nude-2, nude-3."""
    wanted, used = {_file_of(name) for name in names}, set()
    numbers: Counter[str] = Counter()
    found = []
    for name in names:
        one, key = name, _file_of(name)
        while _file_of(one) in used or (one != name and _file_of(one) in wanted):
            numbers[key] += 1
            one = f"{name}-{numbers[key] + 1}"
        used.add(_file_of(one))
        found.append(one)
    return found


def _file_of(name: str) -> str:
    """A key that is the same for names of the same file: some disks do not tell A from a."""
    return in_name(name).casefold()
