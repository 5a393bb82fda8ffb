"""A table of products: strict about what it needs, blind to the rest, and the nearest of them."""

import numpy as np
import pytest
from makeup_video.pipeline import CatalogueError
from makeup_video.pipeline.catalogue import Shade, nearest, read_catalogue

GOOD = 'brand,product,shade,hex\nA,Matte,"Red, dark",#B4002E\nB,Gloss,Pink,f9a\n'
SHADES = (
    Shade("A", "Matte", "Red, dark", (180, 0, 46)),
    Shade("B", "Gloss", "Pink", (255, 153, 170)),
)


@pytest.mark.parametrize(
    "data",
    [
        GOOD.encode(),
        GOOD.encode("utf-8-sig"),
        GOOD.replace("\n", "\r\n").encode(),
        GOOD.replace("\n", "\n\n").encode(),
        GOOD.replace("brand,product", " Brand , PRODUCT").encode(),
        b'finish,hex,shade,product,brand\nmatte,B4002E,"Red, dark",Matte,A\n,#FF99AA,Pink,Gloss,B\n',
    ],
)
def test_quotes_marks_empty_lines_and_other_columns_are_no_matter(tmp_path, data):
    (tmp_path / "shades.csv").write_bytes(data)
    assert read_catalogue(tmp_path / "shades.csv") == SHADES


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "line 1: the columns brand, product, shade, hex are needed"),
        (b"brand,shade,hex\n", "missing or twice: product"),
        (b"brand;product;shade;hex\nA;B;C;#fff\n", "separated by commas; missing or twice: brand"),
        (b"brand,product,shade,hex,hex\n", "missing or twice: hex"),
        (b"brand,product,shade,hex\n", "has no rows"),
        (b"brand,product,shade,hex\nA,B,C,#fff\nA,B,C,red\n", "line 3: hex must be .*, got 'red'"),
        (b"brand,product,shade,hex\nA,B,C,\n", "line 2: hex must be .*, got ''"),
        (
            b"brand,product,shade,hex\nA,B,#fff\n",
            "line 2: 4 cells were expected, as in line 1, got 3",
        ),
        (b"brand,product,shade,hex\nA,B,C,#fff,x\n", "line 2: 4 cells were expected, .* got 5"),
        (b'brand,product,shade,hex\n"A,B,C,#fff\n', "line 2: no proper CSV"),
        ("brand,product,shade,hex\nä,B,C,#fff\n".encode("latin-1"), "not UTF-8 text"),
        (b"brand,product,shade,hex\n" + b"a" * 200_000 + b",B,C,#fff\n", "line 2: no proper CSV"),
    ],
)
def test_each_mistake_is_one_line_with_its_place(tmp_path, data, words):
    (tmp_path / "shades.csv").write_bytes(data)
    with pytest.raises(CatalogueError, match=words) as caught:
        read_catalogue(tmp_path / "shades.csv")
    assert "shades.csv" in str(caught.value) and "\n" not in str(caught.value)
    assert caught.value.exit_code == 2


@pytest.mark.parametrize("name", ["none.csv", "."])
def test_a_file_that_cannot_be_read_says_so(tmp_path, name):
    with pytest.raises(CatalogueError, match="a catalogue cannot be read"):
        read_catalogue(tmp_path / name)


def test_the_nearest_come_first_and_equals_in_their_order():
    reds = [Shade("A", "P", str(red), (red, 0, 46)) for red in (90, 250, 180, 180, 200)]
    found = nearest(reds, (180, 0, 46), 3)
    assert [one for _, one in found] == [reds[2], reds[3], reds[4]]
    assert [off for off, _ in found][:2] == [0, 0] and found[2][0] > 0
    assert len(nearest(reds, (180, 0, 46), 9)) == 5
    assert np.isfinite([off for off, _ in nearest(reds, (0.4, 254.6, 0))]).all()
