"""A list of jobs: a CSV file with a row for each input."""

import csv
import io
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from makeup_video.pipeline.errors import UsageError
from makeup_video.pipeline.files.ordinary import open_ordinary
from makeup_video.pipeline.look.words import did_you_mean

INPUT, OUTPUT = "in", "out"
_MOST_BYTES = 100_000_000


@dataclass(frozen=True, slots=True)
class ListedJob:
    """A row of a list.

    where: its file and line, for messages.  output: a template; None where the row has none.
    options: other cells that are not empty, by column.
    """

    where: str
    source: str
    output: str | None
    options: Mapping[str, str]


def read_jobs(path: str | os.PathLike[str], columns: Sequence[str]) -> list[ListedJob]:
    """The rows of a CSV file (UTF-8) with a column `in`; blank rows do not count.

    columns: what other columns it may have, besides `out`.
    Cells are separated by commas, or by semicolons where line 1 has no comma. Raises UsageError
    naming file, line and fault.
    """
    try:
        with (
            open_ordinary(path, _MOST_BYTES) as data,
            io.TextIOWrapper(data, encoding="utf-8-sig", newline="") as lines,
        ):
            jobs = list(_rows(lines, path, [INPUT, OUTPUT, *columns]))
    except UnicodeDecodeError as error:
        raise UsageError(f"{path}: a list of jobs cannot be read: not UTF-8 text") from error
    except OSError as error:
        raise UsageError(f"{path}: a list of jobs cannot be read: {error.strerror}") from error
    if not jobs:
        raise UsageError(f"{path} has no rows: a list of jobs needs at least one")
    return jobs


def _rows(
    lines: Iterator[str], path: str | os.PathLike[str], known: Sequence[str]
) -> Iterator[ListedJob]:
    first = next(lines, "")
    if not first.strip():
        raise UsageError(f"{path}, line 1 is empty: it must name the columns, such as {INPUT!r}")
    between = "," if "," in first or ";" not in first else ";"
    try:
        cells = next(csv.reader([first], strict=True, delimiter=between))
    except csv.Error as error:
        raise UsageError(f"{path}, line 1: no proper CSV: {error}") from error
    names = [name.strip().lower().replace("-", "_") for name in cells]
    _check_columns(f"{path}, line 1", names, known)
    reader = csv.reader(lines, strict=True, delimiter=between)
    try:
        for row in reader:
            if not "".join(row).strip():
                continue
            where = f"{path}, line {reader.line_num + 1}"
            if len(row) != len(names):
                raise UsageError(
                    f"{where}: {len(names)} cells were expected, as in line 1, got {len(row)}"
                )
            values = {name: cell.strip() for name, cell in zip(names, row, strict=True)}
            source, output = values.pop(INPUT), values.pop(OUTPUT, "")
            if not source:
                raise UsageError(f"{where}: the column {INPUT} is empty: give a file")
            options = {name: cell for name, cell in values.items() if cell}
            yield ListedJob(where, source, output or None, options)
    except csv.Error as error:
        raise UsageError(f"{path}, line {reader.line_num + 1}: no proper CSV: {error}") from error


def _check_columns(where: str, names: Sequence[str], known: Sequence[str]) -> None:
    for name in names:
        if name not in known:
            raise UsageError(
                f"{where}: there is no column {name!r}{did_you_mean(name, known)}; the columns of "
                f"a list of jobs are {', '.join(known)}"
            )
        if names.count(name) > 1:
            raise UsageError(f"{where}: the column {name} stands there twice: leave one out")
    if INPUT not in names:
        raise UsageError(f"{where}: the column {INPUT}, which names the input, is missing")
