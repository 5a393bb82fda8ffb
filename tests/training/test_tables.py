"""Tables of our labels, and how numbers agree with them."""

from math import nan

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.training.worn.scores import agreement
from makeup_video.training.worn.table import photos_of


def test_photos_are_found_in_any_of_the_folders(tmp_path):
    folders = [tmp_path / "one", tmp_path / "other"]
    for folder, name in zip(folders, ("a.jpg", "b.jpg"), strict=True):
        folder.mkdir()
        (folder / name).touch()
    table = tmp_path / "labels.csv"
    table.write_text("name,gloss\nb.jpg,2\nmissing.jpg,1\na.jpg,0.5\n", encoding="utf-8")
    found = photos_of(table, folders)
    assert {path: row["gloss"] for path, row in found.items()} == {
        folders[1] / "b.jpg": "2",
        folders[0] / "a.jpg": "0.5",
    }


@given(st.lists(st.floats(0, 3), min_size=3, max_size=20, unique_by=lambda one: round(one, 1)))
def test_what_nobody_knows_does_not_count_in_agreement(true):
    known = np.array(true)
    said = agreement("gloss", 2 * known, known)
    assert said.startswith("gloss: correlation 1.00, ")
    assert agreement("gloss", np.append(2 * known, 99.0), np.append(known, nan)) == said
