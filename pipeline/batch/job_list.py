"""A list of jobs: a CSV file with a row for each input."""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from makeup_video.pipeline.errors import UsageError
from makeup_video.pipeline.files.table import open_table, table_rows
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

    columns: the other columns that the file may have, besides `out`.
    Cells are separated by commas, or by semicolons where line 1 has no comma. Raises UsageError
    naming file, line and fault.
    """
    with open_table(path, "a list of jobs", _MOST_BYTES, UsageError) as lines:
        jobs = list(_rows(lines, path, [INPUT, OUTPUT, *columns]))
    if not jobs:
        raise UsageError(f"{path} has no rows: a list of jobs needs at least one")
    return jobs


def _rows(
    lines: Iterator[str], path: str | os.PathLike[str], known: Sequence[str]
) -> Iterator[ListedJob]:
    def columns(names: list[str]) -> list[str]:
        names = [name.replace("-", "_") for name in names]
        _check_columns(f"{path}, line 1", names, known)
        return names

    for row in table_rows(lines, path, columns, UsageError):
        values = dict(row.cells)
        source, output = values.pop(INPUT), values.pop(OUTPUT, "")
        if not source:
            raise UsageError(f"{row.where}: the column {INPUT} is empty: give a file")
        options = {name: cell for name, cell in values.items() if cell}
        yield ListedJob(row.where, source, output or None, options)


def _check_columns(where: str, names: Sequence[str], known: Sequence[str]) -> None:
    if not any(names):
        raise UsageError(f"{where} is empty: it must name the columns, such as {INPUT!r}")
    for name in names:
        if name not in known:
            raise UsageError(
                f"{where}: there is no column {name!r}; the columns of a list of jobs are "
                f"{', '.join(known)}{did_you_mean(name, known)}"
            )
        if names.count(name) > 1:
            raise UsageError(f"{where}: the column {name} appears twice: remove one")
    if INPUT not in names:
        raise UsageError(f"{where}: the column {INPUT}, which names the input, is missing")
