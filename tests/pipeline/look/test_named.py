"""Looks by name, from a folder, a pattern or the rows of a catalogue."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import CatalogueError, Layer, Look, LookError, UsageError, product
from makeup_video.pipeline.files.template import in_name
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.named import look_files, looks_of_catalogue, numbered

ROSE = (0x7C, 0x3F, 0x35)
TABLE = """brand,product,category,shade,hex,finish
Rosa,Velvet,lipstick,Berry,#7C3F35,matte
Rosa,Velvet,lip gloss,Plum,602040,glossy
Nero,Kajal,eyeliner,Night,000,
Nero,Pan,eye shadow,Dusk,#6B7475,glitter
Nero,Brow,eyebrow,Oak,#503020,matte
Rosa,Any,,Coral,#FF7F50,lustre
"""


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "shades.csv"
    path.write_text(TABLE)
    return path


def test_every_row_is_a_look_on_its_part(table):
    looks = looks_of_catalogue(table, finish="satin")
    assert [(one.name, one.look.kinds) for one in looks] == [
        ("Rosa-Berry", ("lipstick",)), ("Rosa-Plum", ("lipstick",)),
        ("Nero-Night", ("eyeliner",)), ("Nero-Dusk", ("eyeshadow",)),
        ("Rosa-Coral", ("lipstick",)),
    ]  # fmt: skip
    assert looks[0].look == Look(lips=product(ROSE, "satin"))
    row = {"brand": "Rosa", "product": "Velvet", "shade": "Berry"}
    assert looks[0].fields == {"look": "Rosa-Berry", **row}


def test_rows_of_what_is_not_painted_are_told(table):
    left_out = []
    looks_of_catalogue(table, finish="satin", on_left_out=left_out.append)
    assert left_out == ["eyebrow"]


def test_rows_of_an_unknown_category_are_told(table):
    """A row without any category, such as Coral, is not reported."""
    table.write_text(TABLE.replace("eyeliner", "pencil").replace("lustre", ""))
    told = []
    looks = looks_of_catalogue(table, on_unknown=told.append)
    assert told == ["pencil"]
    assert [one.look.kinds for one in looks if one.shade == "Night"] == [("lipstick",)]
    looks_of_catalogue(table, parts=["liner"], on_unknown=told.append)  # the caller chose the part
    assert told == ["pencil"]


def test_the_finish_of_a_row_counts_unless_one_is_given(table):
    berry, plum = looks_of_catalogue(table, ["brand=rosa", "category=lipstick"]) + (
        looks_of_catalogue(table, ["shade=PLUM"])
    )
    assert berry.look == Look(lips=product(ROSE, "matte"))
    assert plum.look == Look(lips=product((0x60, 0x20, 0x40), "gloss"))
    table.write_text(TABLE.replace(",glossy", ",").replace("lipstick,Berry,#7C3F35,matte",
                                                           "Matte Lipstick,Berry,#7C3F35,"))  # fmt: skip
    berry, plum = looks_of_catalogue(table, ["product=Velvet"])  # the category names the finish
    assert berry.look == Look(lips=product(ROSE, "matte"))
    assert plum.look == Look(lips=product((0x60, 0x20, 0x40), "gloss"))
    (night,) = looks_of_catalogue(table, ["shade=Night"])
    kind = PARTS["liner"]
    assert night.look.layers[0].product == product((0, 0, 0), kind.first_finish, "liner")


@pytest.mark.parametrize(
    ("category", "part", "finish"),
    [("Matt lipstick", "lips", "matte"), ("Lipgloss", "lips", "gloss"), ("lip_stain", "lips", "sheer"),
     ("Glitter Eyeshadow", "eyes", "shimmer"), ("Kohl", "liner", None), ("blush", "blush", None)],
)  # fmt: skip
def test_a_category_names_part_and_finish(table, category, part, finish):
    table.write_text(f"brand,product,shade,hex,category\nA,B,C,#7C3F35,{category}\n")
    (one,) = looks_of_catalogue(table)
    (layer,) = one.look.layers
    kind = PARTS[part]
    assert layer == Layer(kind.name, product(ROSE, finish or kind.first_finish, part))


@pytest.mark.parametrize(
    ("where", "parts", "message"),
    [
        ((), (), r"shades.csv, line 7: finish must be one of .*, got 'lustre'.*finish gives one"),
        (
            ["brand=Nobody"],
            (),
            "no row that meets brand=Nobody; brand is Rosa, Nero: choose",
        ),
        (["category=eyebrow"], (), r"only .* not painted where category=eyebrow \(eyebrow\): give"),
        (["brand=Nero"], ("lips",), "no row that meets brand=Nero and parts lips"),
    ],
)
def test_unreadable_and_missing_rows_are_named(table, where, parts, message):
    with pytest.raises(CatalogueError, match=message):
        looks_of_catalogue(table, where, None, parts)


@pytest.mark.parametrize(
    ("where", "message"),
    [
        ("brand", "must be COLUMN=VALUE"),
        ("=x", "must be COLUMN=VALUE"),
        ("brnd=x", "the column 'brnd', and the catalogue has .*did you mean brand"),
    ],
)
def test_a_condition_that_no_row_can_meet_is_refused(table, where, message):
    with pytest.raises(UsageError, match=message):
        looks_of_catalogue(table, [where], "matte")


def test_parts_choose_among_rows(table):
    names = [one.name for one in looks_of_catalogue(table, (), "matte", ("eyes", "liner"))]
    assert names == ["Nero-Night", "Nero-Dusk", "Rosa-Coral"]  # Coral may be for any part


def test_look_files_of_a_folder_or_a_pattern(tmp_path):
    for name in ("b.json", "a.JSON", "note.txt"):
        (tmp_path / name).write_text("{}")
    assert [path.name for path in look_files(str(tmp_path))] == ["a.JSON", "b.json"]
    assert [path.name for path in look_files(f"{tmp_path}/*.json")] == ["b.json"]
    (tmp_path / "red[1].json").write_text("{}")  # as browsers name a second download
    assert look_files(f"{tmp_path}/red[1].json") == [tmp_path / "red[1].json"]
    (tmp_path / "empty").mkdir()
    nothing = "is no folder, and no look file"
    for place, message in (("empty", "has no look"), ("no/*.json", nothing), ("em*", nothing)):
        with pytest.raises(LookError, match=message):
            look_files(str(tmp_path / place))


def test_hidden_files_and_folders_are_no_look_files(tmp_path):
    (tmp_path / "old.json").mkdir()
    (tmp_path / "._red.json").write_bytes(b"\0\5\x16\7")  # as macOS writes them beside others
    with pytest.raises(LookError, match="has no look files"):
        look_files(str(tmp_path))
    (tmp_path / "red.json").write_text("{}")
    assert [path.name for path in look_files(str(tmp_path))] == ["red.json"]


def test_a_look_keeps_its_own_name_where_others_are_numbered():
    assert numbered(["nude", "nude", "nude-2"]) == ["nude", "nude-3", "nude-2"]


@given(st.lists(st.sampled_from(["nude", "Nude", "nude-2", "NUDE-2", "red/1", "red:1", "red-1-3"])))
def test_numbered_names_are_different_files(names):
    found = numbered(names)
    assert len({in_name(name).casefold() for name in found}) == len(found)
    assert all(one.startswith(name) for one, name in zip(found, names, strict=True))
    assert set(map(in_name, map(str.casefold, names))) <= {in_name(one).casefold() for one in found}


def test_photos_count_in_a_folder_without_look_files(tmp_path):
    for name in ("a.jpg", "b.HEIC", "._d.png", "clip.mp4"):
        (tmp_path / name).write_text("{}")
    assert [path.name for path in look_files(str(tmp_path))] == ["a.jpg", "b.HEIC"]
    (tmp_path / "b.json").write_text("{}")
    assert [path.name for path in look_files(str(tmp_path))] == ["b.json"]
    assert [path.name for path in look_files(f"{tmp_path}/b*")] == ["b.HEIC", "b.json"]
