"""The product catalogue: required columns are checked, others ignored, nearest shades found."""

import os

import numpy as np
import pytest
from makeup_video.pipeline import CatalogueError
from makeup_video.pipeline.files.table import TableRow
from makeup_video.pipeline.look import catalogue as catalogue_module
from makeup_video.pipeline.look.catalogue import Catalogue, Shade, read_catalogue, rows_of
from makeup_video.pipeline.look.ciede2000 import ciede2000, lab_of
from makeup_video.pipeline.look.kinds import PARTS

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
        (GOOD + ",,,\n , ,,\n,,,,,,\n,\n").encode(),
        b'brand;product;shade;hex\nA;Matte;Red, dark;#B4002E\nB;"Gloss";Pink;f9a\n;;;\n',
        GOOD.replace("brand,product", " Brand , PRODUCT").encode(),
        (
            b"finish,hex,shade,product,brand\n"
            b'matte,B4002E,"Red, dark",Matte,A\n,#FF99AA,Pink,Gloss,B\n'
        ),
    ],
)
def test_quotes_empty_lines_and_other_columns_are_ignored(tmp_path, data):
    (tmp_path / "shades.csv").write_bytes(data)
    assert tuple(read_catalogue(tmp_path / "shades.csv")) == SHADES


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "line 1 is empty: a catalogue needs the columns brand"),
        (b"\n", "line 1 is empty: a catalogue needs the columns brand"),
        (b" \n", "line 1: the columns brand, product, shade, hex are needed"),
        (b"brand,shade,hex\n", "missing or twice: product"),
        (b"brand\tproduct\tshade\thex\n", "by commas or semicolons; missing or twice: brand"),
        (b"brand\tproduct\tshade\thex\n", "shade, hex; the line has tabs: save it as CSV in UTF-8"),
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


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("none.csv", r"none\.csv does not exist: give a catalogue \(CSV\) on this machine"),
        (".", "cannot be read as a catalogue"),
    ],
)
def test_a_file_that_cannot_be_read_says_so(tmp_path, name, words):
    with pytest.raises(CatalogueError, match=words):
        read_catalogue(tmp_path / name)


def test_anything_but_an_ordinary_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(CatalogueError, match="it is no ordinary file"):
        read_catalogue(tmp_path / "pipe.csv")
    with pytest.raises(CatalogueError, match="it is no ordinary file"):
        read_catalogue("/dev/zero")
    with pytest.raises(CatalogueError, match="the name of the catalogue is empty"):
        read_catalogue("")


def test_the_nearest_come_first_and_equals_in_their_order():
    reds = [Shade("A", "P", str(red), (red, 0, 46)) for red in (90, 250, 180, 180, 200)]
    catalogue = Catalogue(reds)
    found = catalogue.nearest((180, 0, 46), 3)
    assert [shade for _, shade in found] == [reds[2], reds[3], reds[4]]
    assert [difference for difference, _ in found][:2] == [0, 0] and found[2][0] > 0
    assert len(catalogue.nearest((180, 0, 46), 9)) == 5
    assert np.isfinite([difference for difference, _ in catalogue.nearest((0.4, 254.6, 0))]).all()


def test_a_large_catalogue_gives_what_sorting_all_of_it_gives():
    """More rows than one block holds, with many equal colours. Each brand name is stored once."""
    rgb8 = np.random.default_rng(0).integers(0, 12, (70_000, 3)) * 20
    catalogue = Catalogue(
        Shade("B", "P", str(index), tuple(c)) for index, c in enumerate(rgb8.tolist())
    )
    wanted = (104.0, 61.0, 140.0)
    differences = ciede2000(lab_of(rgb8), lab_of(np.array(wanted)))
    first = np.argsort(differences, kind="stable")[:60]
    found = catalogue.nearest(wanted, 60)
    assert [shade.shade for _, shade in found] == [str(index) for index in first]
    np.testing.assert_allclose(
        [difference for difference, _ in found], differences[first], rtol=1e-12
    )
    assert [shade.rgb for _, shade in found] == [tuple(rgb8[index]) for index in first]
    assert found[0][1].brand is found[1][1].brand


ALL = " ".join(PARTS)
KINDS = [
    ("lip_gloss", "lips"), ("Lip Liner", "lips"), ("LIPSTICK", "lips"), ("Lippenstift", "lips"),
    ("eyeshadow", "eyes"), ("Eye Primer", "eyes"), ("eyeliner", "liner"), ("kohl", "liner"),
    ("jumbo eye-pencil", "eyes"), ("Blush", "blush"), ("rouge", "blush"),
    ("lip & cheek stain", "lips blush"), ("eye and lip pencil", "lips eyes"),
    ("eyes/lips", "lips eyes"), ("", ALL), ("pencil", ALL), ("palette", ALL), ("tulip", ALL),
    ("nail_polish", ""), ("eyebrow", ""), ("Eye Brow gel", ""), ("eyelash", ""), ("mascara", ""),
    ("foundation", ""), ("face powder", ""),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "parts"), KINDS)
@pytest.mark.parametrize("column", ["category", "Product_Type", " type "])
def test_the_kind_of_a_product_gives_its_parts(tmp_path, column, kind, parts):
    (tmp_path / "shades.csv").write_text(f"brand,product,shade,hex,{column}\nA,B,C,#fff,{kind}\n")
    (shade,) = read_catalogue(tmp_path / "shades.csv")
    assert shade.parts == tuple(parts.split())


def test_columns_that_give_the_kind_are_read_together(tmp_path):
    """Shops fill two columns: one with lipstick or eyeshadow, the other with liquid, palette or
    nothing."""
    rows = ["brand,product,product_type,category,shade,hex", "A,B,eyeshadow,,1,#b00",
            "A,B,eyeshadow,palette,2,#b00", "A,B,lipstick,liquid,3,#b00",
            "A,B,,,4,#b00"]  # fmt: skip
    (tmp_path / "shades.csv").write_text("\n".join(rows))
    catalogue = read_catalogue(tmp_path / "shades.csv")
    offered = {
        part: [shade.shade for _, shade in catalogue.nearest((180, 0, 0), part=part)]
        for part in ("lips", "eyes", None)
    }
    assert offered == {"lips": ["3", "4"], "eyes": ["1", "2", "4"], None: ["1", "2", "3", "4"]}


def test_only_products_for_the_part_are_offered(tmp_path):
    codes = np.random.default_rng(0).integers(0, 256, (3000, 3)).tolist()
    parts = ("lips",), ("eyes",), ("lips", "eyes"), ()
    shades = [
        Shade("B", "P", str(index), tuple(code), parts[index % 4])
        for index, code in enumerate(codes)
    ]
    catalogue = Catalogue(shades)
    assert tuple(catalogue) == tuple(shades)
    for part, names in (("lips", (0, 2)), ("eyes", (1, 2))):
        alone = Catalogue(shade for shade in shades if part in shade.parts)
        found = catalogue.nearest((120, 30, 60), 9, part)
        assert found == alone.nearest((120, 30, 60), 9)
        assert {int(shade.shade) % 4 for _, shade in found} <= set(names)
    assert Catalogue(shades[:1]).nearest((0, 0, 0), part="eyes") == []


def test_a_catalogue_that_is_too_large_is_refused(tmp_path, monkeypatch):
    with (tmp_path / "hole.csv").open("wb") as file:
        file.truncate(3_000_000_000)
    with pytest.raises(
        CatalogueError, match="cannot be read as a catalogue: it has more than 200 MB"
    ):
        read_catalogue(tmp_path / "hole.csv")
    monkeypatch.setattr(catalogue_module, "_MOST_LINES", 2)
    (tmp_path / "shades.csv").write_text(GOOD)
    with pytest.raises(CatalogueError, match=r"shades\.csv has more than 2 lines"):
        read_catalogue(tmp_path / "shades.csv")


@pytest.mark.parametrize("name", ["category", "finish", "Type", "price"])
def test_a_column_that_stands_there_twice_is_refused(tmp_path, name):
    path = tmp_path / "shades.csv"
    path.write_text(f"brand,product,shade,hex,{name},{name.upper()} \nA,B,C,#fff,lips,eyes\n")
    with pytest.raises(CatalogueError, match=f"line 1: the column {name.lower()} appears twice"):
        read_catalogue(path)
    path.write_text("brand,product,shade,hex,,\nA,B,C,#fff,x,y\n")  # as Excel writes empty columns
    assert len(read_catalogue(path)) == 1


def test_the_place_of_a_row_is_spelled_only_for_messages(tmp_path, monkeypatch):
    path = tmp_path / "shades.csv"
    path.write_text(GOOD)
    monkeypatch.setattr(TableRow, "where", property(lambda row: pytest.fail("was spelled")))
    assert tuple(read_catalogue(path)) == SHADES
    rows = list(rows_of(path))
    monkeypatch.undo()
    assert [row.where for row in rows] == [f"{path}, line 2", f"{path}, line 3"]
