"""`makeup-video estimate`: the makeup of a photo as text, as JSON and as a look file."""

import json
import os
import pty
import re
import subprocess
import sys

import cv2
import numpy as np
import pytest
from makeup_video.cli.app import app
from makeup_video.pipeline import GraphicsParams, Layer, Look, look_from_photo, product
from makeup_video.pipeline.look.finishes import in_words
from makeup_video.pipeline.reference import estimate
from people import SAMPLES, face_of, grey, put
from PIL import Image
from reference_photos import certain
from typer.testing import CliRunner

PHOTO, WORN_PHOTO = SAMPLES / "portrait.jpg", SAMPLES / "look.jpg"
CATALOGUE = "brand,product,shade,hex\n" + "".join(
    f"B{at},Velvet,Shade {at},#{at:02X}2030\n" for at in range(0, 256, 5)
)
SHADOWS = [
    Layer("eyeshadow", product((90, 70, 60), "matte", "eyes"), {"slot": "outer"}, 0.8),
    Layer("eyeshadow", product((255, 218, 185), "matte", "eyes")),
]
WORN = Look(
    lips=product((180, 0, 46), "gloss"), eyes=product((90.4, 70, 60), "sheer", "eyes")
)  # the look that a test substitutes for the photo's


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shades.csv").write_text(CATALOGUE)
    return tmp_path


@pytest.fixture
def reads(monkeypatch):
    """Replace the reading of photos by a fixed look."""

    def pretend(look):
        monkeypatch.setattr(estimate, "estimate_from", lambda *_: certain(look))

    return pretend


def run(*args):
    return CliRunner().invoke(app, ["estimate", *map(str, args)])


def test_both_regions_print_colour_words_and_numbers(folder, reads):
    reads(WORN)
    done = run(PHOTO)
    assert done.exit_code == 0
    assert done.output.splitlines() == [
        "lips  #B4002E  glossy, opaque (almost certain)",
        "      opacity 0.94, gloss 1.30, gloss_roughness 0.20, reflection 0.25",
        "eyes  #5A463C  sheer, very light coverage (almost certain)",
        "      opacity 0.28, gloss 0.10, gloss_roughness 0.80, reflection 0.00",
        "liner  bare (likely)",
        "blush  bare (likely)",
    ]


def test_every_layer_is_printed_with_its_place_and_strength(folder, reads):
    reads(Look(SHADOWS))
    lines = run(PHOTO).stdout.splitlines()
    assert [lines[0], lines[1], lines[3]] == [
        "lips  bare (likely)",
        "eyes  #5A463C  matte, opaque (outer, 80%; almost certain)",
        "eyes  #FFDAB9  matte, opaque (lid; almost certain)",
    ]
    eyes = json.loads(run(PHOTO, "--json").stdout)["eyes"]
    assert (eyes["place"], eyes["shape"], eyes["strength"]) == (
        "outer, 80%",
        {"slot": "outer"},
        0.8,
    )
    (more,) = eyes["more"]
    assert (more["hex"], more["place"], more["strength"]) == ("#FFDAB9", "lid", 1.0)


def test_a_real_photo_is_read_and_saved_as_a_look_that_paints(folder):
    done = run(WORN_PHOTO, "-o", "look.json")
    assert done.exit_code == 0, done.output
    assert "look.json: look file written\n" in done.stderr
    look = Look.load("look.json")
    assert look == look_from_photo(WORN_PHOTO)
    assert look.lips is not None
    assert f"lips  {look.lips.hex}  {in_words(look.lips)} (" in done.output


def test_the_nearest_products_are_named_for_both_regions(folder, reads):
    reads(WORN)
    lines = run(PHOTO, "--catalogue", "shades.csv").output.splitlines()
    near = [line for line in lines if "Velvet" in line]
    assert len(near) == 10 and len(lines) == 6 + 2 + 10
    assert re.fullmatch(r" +\d+\.\d  #[0-9A-F]{6}  B\d+, Velvet, Shade \d+", near[0])
    off = [float(line.split()[0]) for line in near]
    assert off[:5] == sorted(off[:5]) and off[5:] == sorted(off[5:])


def test_products_for_the_lips_are_not_offered_for_the_eyes(folder, reads):
    reads(WORN)
    rows = [f"B,Velvet,{at},#{at:02x}2040,lipstick" for at in range(20, 40)]
    (folder / "lips.csv").write_text("\n".join(["brand,product,shade,hex,category", *rows]))
    lines = run(PHOTO, "--catalogue", "lips.csv").output.splitlines()
    assert len([line for line in lines if "Velvet" in line]) == 5
    assert lines[-3] == "      no product in the catalogue is for the eyes"
    result = json.loads(run(PHOTO, "--catalogue", "lips.csv", "--json").stdout)
    assert len(result["lips"]["nearest"]) == 5 and result["eyes"]["nearest"] == []


def test_json_holds_everything_that_is_printed(folder, reads):
    reads(Look(lips=WORN.lips))
    result = json.loads(run(PHOTO, "--catalogue", "shades.csv", "--json").stdout)
    assert result["photo"] == str(PHOTO) and result["eyes"] is None
    assert result["worn"] == {"lips": 0.97, "eyes": 0.1, "liner": 0.1, "blush": 0.1}
    lips = result["lips"]
    assert (lips["hex"], lips["words"]) == ("#B4002E", "glossy, opaque")
    assert GraphicsParams.from_dict(lips["params"]) == WORN.lips
    assert len(lips["nearest"]) == 5
    assert set(lips["nearest"][0]) == {"ciede2000", "hex", "brand", "product", "shade"}
    assert "nearest" not in json.loads(run(PHOTO, "--json").stdout)["lips"]


def test_a_bare_face_adds_one_line_about_it(folder, reads):
    reads(Look())
    done = run(PHOTO)
    assert done.exit_code == 0
    assert done.stdout.splitlines() == [
        f"{part}  bare (likely)" for part in ("lips", "eyes", "liner", "blush")
    ]
    assert done.stderr == f"{PHOTO}: no makeup was found, the look is bare\n"


@pytest.mark.parametrize(
    ("settings", "colours"),
    [({"COLORTERM": "truecolor"}, True), ({"COLORTERM": "truecolor", "NO_COLOR": "1"}, False),
     ({"TERM": "dumb"}, False), ({"TERM": "linux"}, False), (None, False)],
)  # fmt: skip
def test_a_patch_of_the_colour_is_shown_on_a_terminal_only(folder, settings, colours):
    """settings None: no terminal. The photo is real, so its numbers are not checked."""
    code = (
        "from makeup_video.cli.estimate import _print\n"
        "params = dict(opacity=1, gloss=0, gloss_roughness=0.5, reflection=0)\n"
        "lips = {'hex': '#B4002E', 'words': 'x' * 200, 'params': params, 'place': ''}\n"
        "_print({'lips': [lips], 'eyes': []}, {'lips': 'likely', 'eyes': 'likely'})"
    )
    words = [sys.executable, "-c", code]
    plain = {name: value for name, value in os.environ.items()
             if name not in ("NO_COLOR", "FORCE_COLOR", "COLORTERM")}  # fmt: skip
    if settings is None:
        output = subprocess.run(words, capture_output=True, check=True, env=plain).stdout
    else:
        screen, terminal = pty.openpty()
        env = {**plain, "TERM": "xterm-256color", **settings}
        subprocess.run(words, stdout=terminal, stdin=subprocess.DEVNULL, check=True, env=env)
        os.close(terminal)
        output = os.read(screen, 10_000)
        os.close(screen)
    assert (b"\x1b[48;2;180;0;46m" in output) == colours == (b"\x1b" in output)
    assert len(output.splitlines()) == 3  # a long line is not broken


@pytest.mark.parametrize(
    ("args", "code", "words"),
    [
        ([""], 3, "InputError: the name of the photo is empty"),
        (["two.png", "-o", ""], 2, "UsageError: the name of the look file is empty"),
        (["none.jpg"], 3, "InputError: none.jpg does not exist"),
        (["none.jpg", "-o", "x.json"], 3, "none.jpg does not exist: give a photo file"),
        ([".", "-o", "x.json"], 3, "InputError: . is a folder: give one photo file\n"),
        (["shades.csv"], 3, "PhotoError: shades.csv is no photo that can be read"),
        (["empty.png"], 3, "PhotoError: empty.png: no face was found"),
        (["two.png"], 3, "SeveralFacesError: two.png: one face was expected, 2 were found"),
        (["two.png"], 3, "or --ref-face largest; there are 0 at ("),
        (["two.png"], 3, "; to see them: makeup-video inspect two.png -o seen.png"),
        (["two.png", "--ref-face", "2"], 3, "there is no face 2 in the photo; it has faces 0 at"),
        (["two.png", "--ref-face", "left"], 2, "UsageError: --ref-face must be largest"),
        (["two.png", "--catalogue", "none.csv"], 2, "CatalogueError: none.csv"),
        (["two.png", "--catalogue", "two.png"], 2, "CatalogueError: two.png"),
        (["two.png", "-o", "two.png", "-y"], 2, "own files"),
        (["two.png", "-o", "link.json", "-y"], 2, "own files"),
        (["two.png", "--catalogue", "shades.csv", "-o", "shades.csv", "-y"], 2, "own files"),
        (["two.png", "-o", "old.json"], 2, "old.json exists already: add -y"),
        (["two.png", "-o", "no/where.json"], 4, "does not exist"),
    ],
)
def test_every_mistake_is_one_line_with_its_exit_code(folder, args, code, words):
    cv2.imwrite("empty.png", np.dstack([grey(), grey()[..., 0]]))
    faces = put(put(grey(900, 600), face_of(150), 20, 60), face_of(130), 480, 60)
    cv2.imwrite("two.png", faces[..., ::-1])
    os.symlink("two.png", "link.json")
    (folder / "old.json").write_text("precious")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    done = run(*args)
    assert done.exit_code == code, done.output
    assert words in done.output and len(done.output.splitlines()) == 1
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


ESCAPES = (
    'brand,product,shade,hex\nB,\x1b[31mRed\x07,"two\nlines",#B4002E\nÉclat,Łódź,日本,#B4002F\n'
)


def script(*args):
    """The command in its own process, with one fixed look for every photo."""
    code = (
        "import sys; from makeup_video.pipeline import Look, product\n"
        "from makeup_video.pipeline.reference import estimate\n"
        "from makeup_video.cli.main import main\n"
        "worn = dict.fromkeys(('lipstick', 'eyeshadow', 'eyeliner', 'blush'), 0.9)\n"
        "look = Look(lips=product((180, 0, 46), 'gloss'))\n"
        "estimate.estimate_from = lambda *_: estimate.Estimate(look, worn)\n"
        f"sys.argv[1:] = {['estimate', *map(str, args)]!r}; main()"
    )
    return [sys.executable, "-c", code]


def test_nothing_in_a_catalogue_reaches_the_terminal_raw(folder, reads):
    reads(WORN)
    (folder / "odd.csv").write_text(ESCAPES)
    done = run(PHOTO, "--catalogue", "odd.csv")
    assert done.exit_code == 0
    assert "\x1b" not in done.stdout and "\x07" not in done.stdout
    assert "B, \\x1b[31mRed\\x07, two\\nlines" in done.stdout.splitlines()[3]


@pytest.mark.parametrize("form", [[], ["--json"]])
def test_names_that_stdout_cannot_encode_are_escaped(folder, form):
    (folder / "odd.csv").write_text(ESCAPES, encoding="utf-8")
    env = {**os.environ, "PYTHONIOENCODING": "ascii"}
    words = script(PHOTO, "--catalogue", "odd.csv", *form)
    done = subprocess.run(words, capture_output=True, check=True, env=env)
    assert b"xc9clat" in done.stdout or b"u00c9clat" in done.stdout


@pytest.mark.parametrize("form", [[], ["--json"]])
def test_a_closed_pipe_is_no_error_and_a_full_disk_is_one(folder, form):
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(script(PHOTO, *form), stdout=writing, stderr=subprocess.PIPE, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")
    if os.path.exists("/dev/full"):
        with open("/dev/full", "w") as full:
            done = subprocess.run(
                script(PHOTO, *form), stdout=full, stderr=subprocess.PIPE, check=False
            )
        assert done.returncode == 4
        assert done.stderr.startswith(b"OutputError: stdout cannot be written: No space left")
        assert len(done.stderr.splitlines()) == 1


def test_one_of_several_faces_is_chosen_by_its_number(folder):
    faces = put(put(grey(900, 600), face_of(150), 20, 60), face_of(130), 480, 60)
    cv2.imwrite("two.png", faces[..., ::-1])
    for chosen in ("0", "1", "largest"):
        assert run("two.png", "--ref-face", chosen).exit_code == 0


def test_yes_overwrites_an_old_look(folder, reads):
    reads(WORN)
    (folder / "look.json").write_text("old")
    assert run(PHOTO, "-o", "look.json", "-y").exit_code == 0
    assert Look.load("look.json") == WORN
    assert {path.name for path in folder.iterdir()} == {"look.json", "shades.csv"}


def test_a_photo_and_its_array_give_the_same_colour(folder):
    lips = json.loads(run(WORN_PHOTO, "--json").stdout)["lips"]
    with Image.open(WORN_PHOTO) as photo:
        assert lips["hex"] == estimate.estimate_look(np.asarray(photo.convert("RGB"))).lips.hex
