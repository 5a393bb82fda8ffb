"""Finds the colours of words that name shades: medians over the products of a table.

    python -m makeup_video.training.shade_names --table DIR/lip_shades.csv berry nude wine

The table has the columns `shade` and `hex`. pipeline/look/words.py lists the printed colours.
"""

import argparse
import csv
import re
from collections.abc import Iterable, Mapping

import numpy as np
from makeup_video.pipeline.look.params import hex_of, rgb_of_hex
from makeup_video.training.inputs import existing

LEAST = 3  # products whose shade has the word


def median_rgb(word: str, rows: Iterable[Mapping[str, str]]) -> tuple[int, ...] | None:
    """The median red, green and blue, 0..255, of the products whose shade has that word; None for
    fewer than LEAST products."""
    colours = [
        rgb_of_hex(row["hex"]) for row in rows if word in re.findall("[a-z]+", row["shade"].lower())
    ]
    known = [colour for colour in colours if colour is not None]
    return tuple(np.median(known, 0).astype(int).tolist()) if len(known) >= LEAST else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--table", type=existing, required=True)
    parser.add_argument("words", nargs="+")
    options = parser.parse_args()
    with options.table.open(newline="", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    for word in options.words:
        rgb = median_rgb(word, rows)
        print(word, "too few" if rgb is None else hex_of(rgb))


if __name__ == "__main__":
    main()
