"""A table: a CSV file (UTF-8) whose first line names the columns."""

import csv
import io
import itertools
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple, TextIO

from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.files.disk_errors import unreadable
from makeup_video.pipeline.files.ordinary import open_ordinary

AS_UTF8 = "save it as CSV in UTF-8, which Excel calls CSV UTF-8"
Columns = Callable[[list[str]], list[str]]


class TableRow(NamedTuple):
    """A row of a table.

    A NamedTuple, since tables have millions of rows and a dataclass would take three times as long.
    line: the number of its first line, from 1.  cells: by column, without blanks around them.
    """

    path: str | os.PathLike[str]
    line: int
    cells: Mapping[str, str]

    @property
    def where(self) -> str:
        """Its file and line, for messages."""
        return f"{self.path}, line {self.line}"


@contextmanager
def open_table(
    path: str | os.PathLike[str], kind: str, most_bytes: int, fault: type[MakeupVideoError]
) -> Iterator[TextIO]:
    """Open a table for `table_rows`.

    kind: what it is, for messages, such as "a list of jobs".  Raises `fault` where it cannot be
    read.
    """
    try:
        with (
            open_ordinary(path, most_bytes) as data,
            io.TextIOWrapper(data, encoding="utf-8-sig", newline="") as lines,
        ):
            yield lines
    except MakeupVideoError:
        raise  # some of our errors are OSErrors, but none is about this file
    except UnicodeDecodeError as error:
        raise fault(f"{path} cannot be read as {kind}: it is not UTF-8 text; {AS_UTF8}") from error
    except FileNotFoundError as error:
        raise fault(f"{path} does not exist: give {kind} (CSV) on this machine") from error
    except OSError as error:
        raise fault(unreadable(path, error, f" as {kind}")) from error


def table_rows(
    lines: Iterator[str],
    path: str | os.PathLike[str],
    columns: Columns,
    fault: type[MakeupVideoError],
) -> Iterator[TableRow]:
    """The rows of a table whose cells are not all blank.

    Cells are separated by commas, or by semicolons where line 1 has no comma.
    columns: gets the names of the columns in lower case, checks them, and returns the names that
    rows use.  Raises `fault`, naming file and line, for text that is not proper CSV.
    """
    first = next(lines, "")
    between = "," if "," in first or ";" not in first else ";"
    reader = csv.reader(itertools.chain([first], lines), strict=True, delimiter=between)
    begin = 1
    try:
        names = columns([name.strip().lower() for name in next(reader, [])])
        begin = reader.line_num + 1
        for row in reader:
            line, begin = begin, reader.line_num + 1  # a cell in quotes may hold several lines
            cells = list(map(str.strip, row))
            if not any(cells):
                continue
            if len(cells) != len(names):
                raise fault(
                    f"{path}, line {line}: {len(names)} cells were expected, as in line 1, got "
                    f"{len(cells)}"
                )
            yield TableRow(path, line, dict(zip(names, cells, strict=True)))
    except csv.Error as error:
        raise fault(f"{path}, line {begin}: no proper CSV: {error}") from error
