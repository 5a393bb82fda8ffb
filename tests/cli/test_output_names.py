"""Names of outputs: templates, their fields, and the message if two outputs share a name."""

import json
import shutil

import pytest
from command_line import LOOK, run
from makeup_video.cli.looks_options import WantedLook
from makeup_video.cli.output_names import NewFolders, name_outputs
from makeup_video.pipeline import Look, OutputError
from people import SAMPLES
from PIL import Image

HEAD = "brand,product,category,shade,hex"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plum.json").write_text(json.dumps(LOOK))
    shutil.copy(SAMPLES / "portrait.jpg", "in.jpg")
    return tmp_path


def looks_named(*names):
    return [WantedLook({"look": name}, lambda quiet: Look(), Look) for name in names]


@pytest.mark.parametrize(
    ("output", "names", "found"),
    [
        ("out.mp4", ["a"], ["out.mp4"]),
        ("./out//x.mp4", ["a"], ["./out//x.mp4"]),
        ("{{a}}.mp4", ["a"], ["{a}.mp4"]),
        ("o/{name}-{look}.{ext}", ["a", "b"], ["o/talk-a.mov", "o/talk-b.mov"]),
        ("{folder}-{look}.mp4", ["a/b"], ["clips-a-b.mp4"]),
    ],
)
def test_names_of_outputs(output, names, found):
    assert name_outputs(output, "/videos/clips/talk.MOV", looks_named(*names)) == found


@pytest.mark.parametrize(
    ("ends", "written"),
    [("mp4 m4v mov mkv webm jpg jpeg png webp", None), ("avi gif mpg 3gp flv mts WMV ogv", "mp4"),
     ("heic HEIF", "jpg")],
)  # fmt: skip
def test_ext_is_an_extension_that_is_written(ends, written):
    for end in ends.split():
        (output,) = name_outputs("{name}.{ext}", f"a.b.{end}", looks_named("x"))
        assert output == f"a.b.{written or end}"


@pytest.mark.parametrize(("is_animated", "written"), [(True, "mp4"), (False, "png")])
def test_ext_of_an_animated_png_is_that_of_a_video(folder, is_animated, written):
    pictures = [Image.new("RGB", (8, 8), colour) for colour in ("red", "blue")]
    pictures[0].save("in.png", save_all=True, append_images=pictures[1:] if is_animated else [])
    assert name_outputs("{name}.{ext}", "in.png", looks_named("x")) == [f"in.{written}"]


TWINS = "shades.csv, line 2 and shades.csv, line"


@pytest.mark.parametrize("command", [[], ["batch"]])
@pytest.mark.parametrize(
    ("row", "template", "message"),
    [
        ("É,P,lips,Rose,#B4002F", "{brand}.jpg", f"two outputs have the name É.jpg ({TWINS} 3): give"),
        ("É,P,lips,,#B4002F", "{shade}.jpg", "a catalogue's row, and shades.csv, line 3 has none: choose"),
        ("G,P,lips,Rose,#B4002F", "{shade}.jpg",
         f"two outputs are one file: Red.jpg and red.jpg ({TWINS} 4); give each its own name"),
    ],
)  # fmt: skip
def test_rows_of_a_catalogue_are_named_by_their_lines(folder, command, row, template, message):
    rows = ["É,P,lips,Red,#B4002E", row, "F,p,lips,red,#B40030"]
    (folder / "shades.csv").write_text("\n".join([HEAD, *rows]))
    done = run(*command, "in.jpg", "--catalogue", "shades.csv", "-o", template)
    assert done.exit_code == 2 and message in done.stderr, done.stderr
    assert "has none" in message or ", for example with {look}." in done.stderr


def test_an_input_without_an_extension_is_named(folder):
    (folder / "in.jpg").rename(folder / "in")
    done = run("in", "--look", "plum.json", "-o", "{look}.{ext}")
    assert done.exit_code == 2 and "{ext}, the input's extension" in done.stderr
    assert ", and in has none: choose another field" in done.stderr


def test_folders_within_new_folders_are_gone_after_an_error(tmp_path):
    with pytest.raises(OutputError), NewFolders() as folders:
        folders.make([str(tmp_path / "a" / "b" / "out.mp4")])
        raise OutputError("full")
    assert list(tmp_path.iterdir()) == []
