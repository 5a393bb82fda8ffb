"""worn.csv: what is worn in each picture of a folder."""

import csv
from pathlib import Path


def has_table(folder: Path) -> bool:
    """Whether a folder's pictures have labels."""
    return _table(folder).exists()


def labelled_rows(folder: Path) -> list[dict[str, str]]:
    """The rows of a folder's worn.csv (UTF-8), by column."""
    with _table(folder).open(newline="", encoding="utf-8") as table:
        return list(csv.DictReader(table))


def _table(folder: Path) -> Path:
    return folder / "worn.csv"
