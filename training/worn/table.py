"""Tables of labels: worn.csv, what is worn in each picture of a folder, and our own."""

import csv
from pathlib import Path


def has_table(folder: Path) -> bool:
    """Whether a folder's pictures have labels."""
    return _table(folder).exists()


def labelled_rows(folder: Path) -> list[dict[str, str]]:
    """The rows of a folder's worn.csv, by column."""
    return rows_of(_table(folder))


def rows_of(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file (UTF-8), by column."""
    with path.open(newline="", encoding="utf-8") as table:
        return list(csv.DictReader(table))


def _table(folder: Path) -> Path:
    return folder / "worn.csv"
