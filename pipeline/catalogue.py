"""A table of real products, and which of them come nearest to a colour."""

import csv
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from makeup_video.pipeline.choose import rgb_of_hex
from makeup_video.pipeline.colour_difference import ciede2000, lab_of
from makeup_video.pipeline.errors import CatalogueError

COLUMNS = ("brand", "product", "shade", "hex")


@dataclass(frozen=True, slots=True)
class Shade:
    """One shade of one product; rgb: sRGB codes 0..255."""

    brand: str
    product: str
    shade: str
    rgb: tuple[int, int, int]


def read_catalogue(path: str | os.PathLike[str]) -> tuple[Shade, ...]:
    """The rows of a CSV file (UTF-8) with columns brand, product, shade, hex; others are ignored.

    Raises CatalogueError naming file, line and fault.
    """
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as file:
            shades = tuple(_shades(file, path))
    except (OSError, UnicodeDecodeError, ValueError) as error:
        if isinstance(error, CatalogueError):
            raise
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise CatalogueError(f"{path}: a catalogue cannot be read: {reason}") from error
    if not shades:
        raise CatalogueError(f"{path} has no rows: a catalogue needs at least one product")
    return shades


def _shades(lines: Iterator[str], path: str | os.PathLike[str]) -> Iterator[Shade]:
    reader = csv.reader(lines, strict=True)
    try:
        names = [name.strip().lower() for name in next(reader, [])]
        missing = [name for name in COLUMNS if names.count(name) != 1]
        if missing:
            raise CatalogueError(
                f"{path}, line 1: the columns {', '.join(COLUMNS)} are needed once each, separated by "
                f"commas; missing or twice: {', '.join(missing)}"
            )
        places = [names.index(name) for name in COLUMNS]
        for row in reader:
            if not row:
                continue
            if len(row) != len(names):
                raise CatalogueError(
                    f"{path}, line {reader.line_num}: {len(names)} cells were expected, as in line 1, "
                    f"got {len(row)}"
                )
            brand, product, shade, text = (row[at].strip() for at in places)
            rgb = rgb_of_hex(text)
            if rgb is None:
                raise CatalogueError(
                    f"{path}, line {reader.line_num}: hex must be 3 or 6 hex digits such as #B4002E, "
                    f"got {text[:40]!r}"
                )
            yield Shade(brand, product, shade, rgb)
    except csv.Error as error:
        raise CatalogueError(f"{path}, line {reader.line_num}: no proper CSV: {error}") from error


def nearest(
    shades: Sequence[Shade], rgb: Sequence[float], count: int = 5
) -> list[tuple[float, Shade]]:
    """The shades that look most like a colour (sRGB codes 0..255) and their CIEDE2000, best first.

    Of several that are equally near, those that come first in the catalogue.
    """
    codes = np.array([one.rgb for one in shades], np.float64)
    off = ciede2000(lab_of(codes), lab_of(np.array(rgb, np.float64)))
    return [(float(off[at]), shades[at]) for at in np.argsort(off, kind="stable")[:count]]
