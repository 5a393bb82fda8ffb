"""A table of real products, and which of them come nearest to a colour."""

import io
import os
import re
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from makeup_video.pipeline.errors import CatalogueError
from makeup_video.pipeline.files.table import AS_UTF8, TableRow, open_table, table_rows
from makeup_video.pipeline.look.ciede2000 import ciede2000, lab_of
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.params import rgb_of_hex

COLUMNS = ("brand", "product", "shade", "hex")
KIND_COLUMNS = ("category", "product_type", "type")  # a product's category; each may be missing
_MOST_BYTES = 200_000_000
_MOST_LINES = 3_000_000  # of 60 bytes each, as catalogues have them
# Words for products of a part of a look, as in lip_gloss, Lippenstift, eyeliner; and words for
# products of no part.
_OF_PART = {part: re.compile(kind.category) for part, kind in PARTS.items()}
_OF_NONE = re.compile(
    r"(?<![a-z])(eye[ _-]?)?(brow|lash|mascara|nail|face|foundation|concealer|bronzer)"
)
_BLOCK = 1 << 15  # rows at a time: CIEDE2000 holds some thirty arrays of them


class Shade(NamedTuple):
    """One shade of one product.

    rgb: sRGB codes 0..255.  parts: the parts that it may be for, all when nothing is known.
    """

    brand: str
    product: str
    shade: str
    rgb: tuple[int, int, int]
    parts: tuple[str, ...] = tuple(PARTS)


class Catalogue:
    """Shades in the order given. A million of them take some 100 MB, since each name of a
    brand or a product is stored once."""

    def __init__(self, shades: Iterable[Shade]) -> None:
        once: dict[str, str] = {}
        self._names: tuple[list[str], list[str], list[str]] = [], [], []
        codes = array("B")
        numbers: dict[tuple[str, ...], int] = {}  # one for each set of parts
        fits = array("H")
        brands, products, names = self._names
        for brand, product, name, rgb, parts in shades:
            brands.append(once.setdefault(brand, brand))
            products.append(once.setdefault(product, product))
            names.append(name)
            codes.extend(rgb)
            fits.append(numbers.setdefault(parts, len(numbers)))
        self._rgb = np.frombuffer(codes.tobytes(), np.uint8).reshape(-1, 3)
        number = np.array(fits, np.intp)
        self._fits = {
            name: np.array([name in parts for parts in numbers], bool)[number] for name in PARTS
        }
        self._lab = [lab_of(block) for block in _blocks(self._rgb)]

    def __len__(self) -> int:
        return len(self._rgb)

    def __iter__(self) -> Iterator[Shade]:
        return (self.at(index) for index in range(len(self)))

    def at(self, index: int) -> Shade:
        brand, product, shade = (column[index] for column in self._names)
        red, green, blue = self._rgb[index].tolist()
        parts = tuple(name for name in PARTS if self._fits[name][index])
        return Shade(brand, product, shade, (red, green, blue), parts)

    def nearest(
        self, rgb: Sequence[float], count: int = 5, part: str | None = None
    ) -> list[tuple[float, Shade]]:
        """The shades that look most like a colour (sRGB codes 0..255), each after its CIEDE2000
        difference, best first.

        Equally near shades come in the order of the catalogue.  part: shades that are known to be
        for other parts are left out.
        """
        fit = np.ones(len(self), bool) if part is None else self._fits[part]
        count = min(count, int(fit.sum()))
        if count < 1:
            return []
        wanted = lab_of(np.array(rgb, np.float64))
        off = np.concatenate([ciede2000(block, wanted) for block in self._lab])
        off[~fit] = np.inf
        # all as near as the last one: argpartition alone would choose any of several equals
        near = np.flatnonzero(off <= off[np.argpartition(off, count - 1)[count - 1]])
        near = near[np.argsort(off[near], kind="stable")][:count]
        return [(float(off[index]), self.at(index)) for index in near.tolist()]


class Row(NamedTuple):
    """One row of a catalogue.

    in_table: all of its cells.  kind: its category in the catalogue's words, in lower case.
    """

    in_table: TableRow
    shade: Shade
    kind: str

    @property
    def where(self) -> str:
        """Its file and line, for messages."""
        return self.in_table.where

    @property
    def cells(self) -> Mapping[str, str]:
        """All of its cells by column, names in lower case."""
        return self.in_table.cells


def read_catalogue(path: str | os.PathLike[str]) -> Catalogue:
    """The rows of a CSV file, see rows_of. Raises CatalogueError naming file, line and fault."""
    catalogue = Catalogue(row.shade for row in rows_of(path))
    if not len(catalogue):
        raise CatalogueError(f"{path} has no rows: a catalogue needs at least one product")
    return catalogue


def rows_of(path: str | os.PathLike[str]) -> Iterator[Row]:
    """The rows of a CSV file (UTF-8, at most 200 MB) with columns brand, product, shade, hex.

    The columns category, product_type and type name the parts that a product is for. Other
    columns are ignored, but no two columns may have the same name.
    Cells are separated by commas, or by semicolons where line 1 has no comma. Rows whose cells are
    all blank do not count. Raises CatalogueError naming file, line and fault.
    """
    if not os.fspath(path):
        raise CatalogueError("the name of the catalogue is empty: give a CSV file")
    with open_table(path, "a catalogue", _MOST_BYTES, CatalogueError) as lines:
        yield from _rows(lines, path)


def rows_in(data: bytes, name: str) -> Iterator[Row]:
    """The rows in a CSV file's bytes, read as by rows_of; messages call the file `name`."""
    try:
        yield from _rows(io.StringIO(data.decode("utf-8-sig"), newline=""), name)
    except UnicodeDecodeError as error:
        raise CatalogueError(
            f"{name} cannot be read as a catalogue: it is not UTF-8 text; {AS_UTF8}"
        ) from error


def _rows(lines: Iterator[str], path: str | os.PathLike[str]) -> Iterator[Row]:
    for row in table_rows(lines, path, lambda names: _checked(names, path), CatalogueError):
        if row.line > _MOST_LINES:
            raise CatalogueError(
                f"{path} has more than {_MOST_LINES} lines: give a catalogue of fewer products"
            )
        cells = row.cells
        kind, parts = _kind(*[text for name, text in cells.items() if name in KIND_COLUMNS])
        rgb = rgb_of_hex(cells["hex"])
        if rgb is None:
            raise CatalogueError(
                f"{row.where}: hex must be 3 or 6 hex digits such as #B4002E, got "
                f"{cells['hex'][:40]!r}"
            )
        shade = Shade(cells["brand"], cells["product"], cells["shade"], rgb, parts)
        yield Row(row, shade, kind)


def _checked(names: list[str], path: str | os.PathLike[str]) -> list[str]:
    """The names of a catalogue's columns. Raises CatalogueError where one is missing or twice."""
    counts = Counter(names)
    missing = [name for name in COLUMNS if counts[name] != 1]
    if not names:
        raise CatalogueError(
            f"{path}, line 1 is empty: a catalogue needs the columns {', '.join(COLUMNS)}"
        )
    if missing:
        tabs = f"; the line has tabs: {AS_UTF8}" if any("\t" in name for name in names) else ""
        raise CatalogueError(
            f"{path}, line 1: the columns {', '.join(COLUMNS)} are needed once each, separated "
            f"by commas or semicolons; missing or twice: {', '.join(missing)}{tabs}"
        )
    twice = next((name for name, count in counts.items() if name and count > 1), None)
    if twice is not None:
        raise CatalogueError(f"{path}, line 1: the column {twice} appears twice: remove one")
    return names


@lru_cache(maxsize=1000)
def _kind(*cells: str) -> tuple[str, tuple[str, ...]]:
    """A product's category, in lower case, and the parts that it is for; all when no word is known.

    cells: the cells in KIND_COLUMNS.
    """
    kind = " ".join(cells).lower()
    named = tuple(name for name in PARTS if _OF_PART[name].search(kind))
    return kind.strip(), named or (() if _OF_NONE.search(kind) else tuple(PARTS))


def _blocks(rows: np.ndarray) -> Iterator[np.ndarray]:
    return (rows[at : at + _BLOCK] for at in range(0, len(rows), _BLOCK))
