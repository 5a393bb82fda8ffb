"""Tables of labels: a folder's worn.csv, which lists the makeup in its pictures, and our own."""

import csv
from collections.abc import Sequence
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


def photos_of(path: Path, folders: Sequence[Path]) -> dict[Path, dict[str, str]]:
    """The rows of a CSV file of labels, by the photo that each names in one of these folders."""
    places = [(folder / row["name"], row) for row in rows_of(path) for folder in folders]
    return {photo: row for photo, row in places if photo.exists()}


def _table(folder: Path) -> Path:
    return folder / "worn.csv"
