"""The options of `apply`: the look, the faces, the comparison and the saved look."""

import json
import os
import subprocess
import sys

import cv2
import numpy as np
import pytest
from makeup_video.cli.app import app
from makeup_video.pipeline import Layer, Look, look_from_photo, product
from makeup_video.pipeline.look.finishes import look_in_words
from makeup_video.pipeline.reference import estimate
from media import decoded, make_clip
from people import SAMPLES, clip, portrait, write_video
from reference_photos import certain
from typer.testing import CliRunner

PHOTO = SAMPLES / "portrait.jpg"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*args):
    return CliRunner().invoke(app, [str(arg) for arg in args])


def test_a_colour_and_a_finish_paint_a_video(folder):
    write_video(folder / "in.mkv", clip(4))
    done = run("in.mkv", "--color", "#B4002E", "--finish", "satin", "-o", "out.mp4",
               "--report", "r.json")  # fmt: skip
    assert done.exit_code == 0, done.output
    assert len(decoded(folder / "out.mp4")) == 4
    report = json.loads((folder / "r.json").read_text())
    wanted = {"faces": 1, "frames_with_face": 4, "tiny_faces": 0, "painted_frames": 4}
    assert {name: report[name] for name in wanted} == wanted


@pytest.mark.parametrize(
    ("words", "look"),
    [
        (["--color", "B02"], Look(lips=product((187, 0, 34), "satin"))),
        (["--color", "#0A2A8C", "--finish", "gloss"], Look(lips=product((10, 42, 140), "gloss"))),
        (
            ["--color", "0a2a8c", "--parts", "eyes", "--zone", "crease", "--intensity", "50%"],
            Look(eyes=product((10, 42, 140), "satin", "eyes"), zone="crease", intensity=0.5),
        ),
        (["--look", "old.json"], Look(lips=product((1, 2, 3), "matte"), strength=0.5)),
        (
            ["--look", "old.json", "--finish", "gloss", "--strength", "1"],
            Look(lips=product((1, 2, 3), "gloss")),
        ),
        (
            ["--look", "old.json", "--lips", "red:shiny", "--eyes", "Dark Red:matt:outer:80%"],
            Look(
                lips=product((255, 0, 0), "gloss"),
                eyes=product((139, 0, 0), "matte", "eyes"),
                zone="outer",
                intensity=0.8,
                strength=0.5,
            ),
        ),
        (["--eyes", "navy"], Look([Layer("eyeshadow", product((0, 0, 128), "satin", "eyes"))])),
        (
            ["--look", "old.json", "--lips", "none", "--liner", "black:matte:wing=.2"],
            Look([Layer("eyeliner", product((0, 0, 0), "matte", "liner"), {"wing": 0.2})], 0.5),
        ),
        (["--look", "none"], Look()),
        (["--look", "none", "--color", "000"], Look(lips=product((0, 0, 0), "satin"))),
    ],
)
def test_the_look_that_is_painted_can_be_saved_and_used_again(folder, words, look):
    Look(lips=product((1, 2, 3), "matte"), strength=0.5).save("old.json")
    done = run(PHOTO, *words, "-o", "one.png", "--save-look", "new.json")
    assert done.exit_code == 0, done.output
    assert Look.load("new.json") == look
    assert run(PHOTO, "--look", "new.json", "-o", "two.png").exit_code == 0
    np.testing.assert_array_equal(cv2.imread("one.png"), cv2.imread("two.png"))
    names = {"old.json", "new.json", "one.png", "two.png"}
    assert {path.name for path in folder.iterdir()} == names


@pytest.mark.parametrize(
    ("save", "report", "code", "message"),
    [
        ("old.json", None, 2, "old.json exists already: add -y"),
        ("base.json", None, 2, "the look file base.json is one of this run's own files"),
        ("twin.json", None, 2, "the look file twin.json is one of this run's own files"),
        ("out.png", None, 2, "one of this run's own files"),
        ("out.part.png", None, 2, "one of this run's own files"),
        ("both.json", "both.json", 2, "one of this run's own files"),
        ("both.json", "both.part.json", 2, "one of this run's own files"),
        ("both.part.json", "both.json", 2, "one of this run's own files"),
        ("no/new.json", None, 4, "the folder no does not exist"),
        (".", None, 4, "the look file . is a folder"),
    ],
)
def test_a_saved_look_never_takes_the_place_of_another_file(folder, save, report, code, message):
    Look(lips=product((1, 2, 3), "matte")).save("base.json")
    os.link("base.json", "twin.json")
    (folder / "old.json").write_text("precious")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    words = [] if report is None else ["--report", report]
    yes = [] if save == "old.json" else ["-y"]
    done = run(PHOTO, "--look", "base.json", "-o", "out.png", "--save-look", save, *words, *yes)
    assert done.exit_code == code, done.output
    assert message in done.output and len(done.output.splitlines()) == 1
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_yes_overwrites_an_old_look_and_an_error_keeps_it(folder):
    (folder / "look.json").write_text("old")
    words = [PHOTO, "--color", "B02", "--save-look", "look.json", "-y"]
    assert run(*words, "-o", "out.xyz").exit_code == 2
    assert (folder / "look.json").read_text() == "old"
    assert run(*words, "-o", "out.png").exit_code == 0
    assert Look.load("look.json") == Look(lips=product((187, 0, 34), "satin"))


def test_a_comparison_is_twice_as_wide(folder):
    assert run(PHOTO, "--color", "B02", "--compare", "-o", "out.png").exit_code == 0
    both, photo = cv2.imread("out.png"), cv2.imread(str(PHOTO))
    width = photo.shape[1]
    np.testing.assert_array_equal(both[:, :width], photo)
    assert (both[:, width:] != photo).any()


def test_a_video_without_a_face_is_reported_but_no_error(folder):
    make_clip(folder / "in.mp4")
    done = run("in.mp4", "--color", "B02", "-o", "out.mp4")
    assert done.exit_code == 0
    assert done.output.startswith("no face was found: nothing was painted; if the video is upside")
    quiet = run("in.mp4", "--color", "B02", "-o", "out.mp4", "-y", "-q")
    assert (quiet.exit_code, quiet.output) == (0, "")


@pytest.mark.parametrize("device", ["0", "pthread"])
def test_a_device_is_chosen_by_number_or_name(folder, device):
    cv2.imwrite("in.png", portrait()[..., ::-1])
    assert run("in.png", "--color", "B02", "--device", device, "-o", "o.png").exit_code == 0


@pytest.mark.parametrize("device", ["99", "none such"])
@pytest.mark.parametrize("name", ["in.mkv", "in.png"])
def test_a_device_that_is_not_there_is_one_line_and_no_file(folder, name, device):
    write_video(folder / "in.mkv", clip(1))
    cv2.imwrite("in.png", portrait()[..., ::-1])
    done = run(name, "--color", "B02", "--device", device, "-o", f"out{name[2:]}")
    assert done.exit_code == 2 and len(done.output.splitlines()) == 1
    assert repr(device) in done.output
    assert {path.name for path in folder.iterdir()} == {"in.mkv", "in.png"}


@pytest.fixture
def reads(monkeypatch):
    """Replace the reading of photos by a fixed look."""

    def pretend(look):
        monkeypatch.setattr(estimate, "estimate_from", lambda *_: certain(look))

    return pretend


def test_the_makeup_of_a_photo_is_painted_and_described(folder):
    read = look_from_photo(PHOTO)
    color = ["--color", "B02"] if read.is_bare else []
    done = run(PHOTO, "--ref", PHOTO, *color, "-o", "out.png", "--save-look", "look.json")
    assert done.exit_code == 0, done.output
    if not color:
        assert Look.load("look.json") == read
    assert f"{PHOTO}: lips " in done.output and "; eyes " in done.output
    assert (cv2.imread("out.png") != cv2.imread(str(PHOTO))).any()


@pytest.mark.parametrize(
    ("words", "look"),
    [
        ([], Look(lips=product((180, 0, 46), "gloss"))),
        (["--ref-face", "largest"], Look(lips=product((180, 0, 46), "gloss"))),
        (["--color", "00F"], Look(lips=product((0, 0, 255), "gloss"))),
        (["--finish", "matte"], Look(lips=product((180, 0, 46), "matte"))),
        (["--strength", "0.5"], Look(lips=product((180, 0, 46), "gloss"), strength=0.5)),
        (
            ["--parts", "eyes", "--color", "00F", "--zone", "outer", "--intensity", "0.5"],
            Look(eyes=product((0, 0, 255), "satin", "eyes"), zone="outer", intensity=0.5),
        ),
    ],
)
def test_options_override_what_the_photo_showed(folder, reads, words, look):
    reads(Look(lips=product((180, 0, 46), "gloss")))
    words = [*words, "-o", "out.png", "--save-look", "look.json"]
    done = run(PHOTO, "--ref", PHOTO, *words)
    assert done.exit_code == 0, done.output
    read, painted = done.output.splitlines()[:2]
    assert read.startswith(f"{PHOTO}: lips #B4002E, glossy, opaque (almost certain); eyes bare (li")
    is_changed = look != Look(lips=product((180, 0, 46), "gloss"))
    assert painted.startswith("painted: ") == is_changed
    if is_changed:
        assert painted == f"painted: {look_in_words(look, with_bare=False)}"
    assert Look.load("look.json") == look
    assert run(PHOTO, "--ref", PHOTO, *words, "-q", "-y").output == ""


def test_parts_that_options_leave_out_are_not_named(folder, reads):
    worn = Look(lips=product((180, 0, 46), "gloss"), eyes=product((90, 58, 46), "matte", "eyes"))
    reads(worn)
    words = ["--ref", PHOTO, "--parts", "lips", "-o", "out.png", "-y"]
    done = run(PHOTO, *words, "--color", "berry")
    assert "painted: lips #9D354F, glossy, opaque\n" in done.output
    done = run(PHOTO, *words, "--lips", "none")
    line = "with --parts and --lips the look portrait has no makeup: nothing is painted on"
    assert "painted: nothing\n" in done.output and line in done.output


def test_parts_that_the_photo_leaves_bare_need_a_colour(folder, reads):
    reads(Look(lips=product((180, 0, 46), "gloss")))
    done = run(PHOTO, "--ref", PHOTO, "--parts", "eyes", "-o", "out.png")
    assert done.exit_code == 2
    assert "--parts names the eyes, which the look leaves bare: add --color" in done.output


def test_a_photo_without_makeup_is_refused_without_a_colour(folder, reads):
    reads(Look())
    done = run(PHOTO, "--ref", PHOTO, "-o", "out.png")
    assert done.exit_code == 3 and len(done.output.splitlines()) == 1
    assert "no makeup was found to paint: add --color '#B4002E', or give another" in done.output
    done = run(PHOTO, "--ref", PHOTO, "--color", "B02", "-o", "out.png", "--save-look", "look.json")
    assert done.exit_code == 0
    assert Look.load("look.json") == Look(lips=product((187, 0, 34), "satin"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--strength", "2"], "--strength"), (["--zone", "nose"], "--zone"),
        (["--color", "rot"], "--color"), (["--finish", "dull"], "--finish"),
        (["--parts", "nose"], "--parts"), (["-o", "old.png"], "old.png exists already"),
        (["-o", ""], "the name of the output is empty"),
    ],
)  # fmt: skip
def test_options_are_refused_before_the_photo_is_read(folder, monkeypatch, words, message):
    def fails(*_):
        raise AssertionError("the photo was read")

    monkeypatch.setattr(estimate, "estimate_from", fails)
    (folder / "old.png").write_text("precious")
    done = run(PHOTO, "--ref", PHOTO, "-o", "out.png", *words)
    assert done.exit_code == 2, done.output
    assert message in done.output and len(done.output.splitlines()) == 1


@pytest.mark.parametrize(
    ("out", "more"),
    [
        ("look.png", []), ("link.png", []), ("twin.png", []), ("part.png", []),
        ("out.png", ["--save-look", "look.png"]), ("out.png", ["--report", "twin.png"]),
        ("look.part.png", ["--save-look", "look.part.png"]),
    ],
)  # fmt: skip
def test_the_photo_is_never_overwritten(folder, reads, out, more):
    reads(Look(lips=product((180, 0, 46), "gloss")))
    cv2.imwrite("look.png", portrait()[..., ::-1])
    os.symlink("look.png", "link.png")
    os.link("look.png", "twin.png")
    os.link("look.png", "part.part.png")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    done = run(PHOTO, "--ref", "look.png", "-o", out, "-y", *more)
    assert done.exit_code == 2, done.output
    assert "which this run reads" in done.output or "own files" in done.output
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_painting_nothing_loads_no_nets_and_no_opencl(folder):
    make_clip(folder / "in.mp4")
    code = (
        "import sys; from makeup_video.cli.app import app\n"
        "app(['in.mp4', '--look', 'none', '-o', 'out.mp4', '-q'], standalone_mode=False)\n"
        "app(['in.mp4', '--color', 'B02', '--strength', '0', '-o', 'two.mp4', '-q'],\n"
        "    standalone_mode=False)\n"
        "heavy = {'cv2', 'onnxruntime', 'pyopencl', 'rich.progress'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--look", "caty"], "did you mean cat-eye?"),
        (["--finish", "gloss"], "--finish gloss needs a colour"),
        (["--ref", "cat-eye"], "--ref takes a photo, and cat-eye is a look: use --look cat-eye"),
        (["--look", "empty.json"], "out.mp4 exists already: add -y"),
    ],
)
def test_a_mistake_in_the_look_is_said_before_an_old_file(folder, words, message):
    make_clip(folder / "in.mp4")
    Look().save("empty.json")
    (folder / "out.mp4").write_bytes(b"old")
    done = run("in.mp4", *words, "-o", "out.mp4")
    assert done.exit_code in (2, 3) and message in done.output
    assert (folder / "out.mp4").read_bytes() == b"old"


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["empty.json"], "the look empty has no makeup: nothing is painted on in.mp4"),
        (["none.json"], "the look none has no makeup: nothing is painted on in.mp4"),
        (["glam", "--strength", "0"], "the look glam is at a strength of 0: nothing is painted"),
        (["none"], None),
        (
            ["glam", "--parts", "lips", "--lips", "none"],
            "with --parts and --lips the look glam has no",
        ),
    ],
)
def test_a_look_without_makeup_is_said_to_paint_nothing(folder, words, line):
    make_clip(folder / "in.mp4")
    for name in ("empty.json", "none.json"):
        Look().save(name)
    done = run("in.mp4", "--look", *words, "-o", "out.mp4")
    assert done.exit_code == 0
    assert f"\n{line}" in f"\n{done.output}" if line else "nothing is painted" not in done.output
