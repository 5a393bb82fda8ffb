"""`apply` with several looks: options that give them, warnings said once, errors of one look."""

import json
import shutil
from pathlib import Path

import pytest
from command_line import LOOK, run
from makeup_video.cli.looks_options import LooksOptions
from makeup_video.cli.many import print_outcomes, titled
from makeup_video.pipeline import KINDS, OutputError, Report, UsageError, product
from people import SAMPLES, clip, write_video
from typer import Exit

TABLE = "brand,product,category,shade,hex\nA,P,lipstick,Red,#B4002E\nB,P,eyes,Dusk,#6B7475\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "looks").mkdir()
    for name in ("looks/red.json", "plum.json"):
        (tmp_path / name).write_text(json.dumps(LOOK))
    (tmp_path / "shades.csv").write_text(TABLE)
    shutil.copy(SAMPLES / "portrait.jpg", "in.jpg")
    return tmp_path


def test_looks_of_every_source_are_painted(folder):
    done = run("in.jpg", "--look", "plum.json", "--look", "cat-eye", "--ref", SAMPLES / "look.jpg",
               "--looks", "looks", "--catalogue", "shades.csv", "--finish", "matte",
               "-o", "out/{name}-{look}.jpg")  # fmt: skip
    assert done.exit_code == 0, done.stderr
    assert sorted(path.name for path in (folder / "out").iterdir()) == [
        f"in-{name}.jpg" for name in ("A-Red", "B-Dusk", "cat-eye", "look", "plum", "red")
    ]
    assert done.stderr.splitlines()[-1].startswith("6 of 6 looks of in.jpg in ")


def test_a_template_of_one_look_is_filled_in(folder):
    done = run(
        "in.jpg", "--catalogue", "shades.csv", "--where", "brand=b", "-o", "{brand}/{shade}.png"
    )
    assert done.exit_code == 0 and (folder / "B" / "Dusk.png").exists()


def test_a_video_in_several_looks_has_one_report(folder):
    write_video(folder / "in.mkv", clip(4))
    done = run("in.mkv", "--look", "plum.json", "--look", "none", "-o", "{look}.mkv",
               "--report", "report.json", "--codec", "ffv1")  # fmt: skip
    assert done.exit_code == 0, done.stderr
    outputs = json.loads((folder / "report.json").read_text())["outputs"]
    assert [(one["output"], one["painted_frames"]) for one in outputs] == [
        ("plum.mkv", 4), ("none.mkv", None),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-o", "out.jpg"], "2 looks need a name each: put {look} in -o, as in -o 'out-{look}.jpg'"),
        (["-o", "{name}.jpg"], "2 looks need a name each"),
        (["-o", "out/"], "put {look} in -o, as in -o 'out/{name}-{look}.{ext}'"),
        (["-o", "{look}.jpg", "--catalogue", "shades.csv", "--where", "brand=A", "--lips", "red"],
         "shades.csv: every row that is painted gives the lips, and so does --lips: leave --lips out"),
        (["-o", "{look}{x}.jpg"], "--output has {x}: the fields are {name}, {folder}, {ext}"),
        (["-o", "{brand}.jpg"], "--output has {brand}, the brand of a catalogue's row, and plum has"),
        (["-o", "{look}.jpg", "--save-look", "a.json"], "--save-look writes one look"),
        (["-o", "{look}.txt"], "the output must end in .jpg, .png or .webp"),
        (["-o", "{look}.jpg", "--where", "brand=A"], "--where chooses rows of a catalogue"),
        (["-o", "{look}.jpg", "--catalogue", "shades.csv", "--color", "red"], "both give the colour"),
        (["-o", "{look}.jpg", "--report", "plum.jpg"], "is one of this run's own files"),
        (["-o", "{look}.jpg", "--report", "cat-eye.jpg"], "is one of this run's own files"),
        (["-o", "{look}/a.jpg", "--ref-face", "0"], "--ref-face chooses a face of the photo"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_said_before_the_work(folder, words, message):
    done = run("in.jpg", "--look", "plum.json", "--look", "cat-eye", *words)
    assert done.exit_code == 2 and message in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert not list(folder.glob("*.part.*")) and len(list(folder.glob("*.jpg"))) == 1


@pytest.mark.parametrize(
    "words", [["--finish", "satin"], ["--zone", "outer"], ["--intensity", "50%"]]
)
def test_options_change_the_rows_that_they_are_for(folder, words):
    """A row of every part: only eyes have a zone, and only lips and eyes follow a colour."""
    kinds = ("lipstick", "eyeshadow", "eyeliner", "blush", "highlighter")
    rows = (f"A,P,{kind},{kind},#B4602E\n" for kind in kinds)
    (folder / "shades.csv").write_text(TABLE.splitlines(keepends=True)[0] + "".join(rows))
    done = run("in.jpg", "--catalogue", "shades.csv", *words, "-o", "{shade}.jpg")
    assert done.exit_code == 0, done.stderr
    assert sorted(path.stem for path in folder.glob("*.jpg")) == sorted((*kinds, "in"))
    options = LooksOptions(catalogue="shades.csv", zone="outer", intensity="50%", finish="satin")
    layers = [one for row in options.wanted(quiet=True) for one in row.load(True).layers]
    assert [layer.kind for layer in layers] == list(kinds)
    changed = [one for one in layers if one.shape == {"slot": "outer"} and one.strength == 0.5]
    assert changed == [layer for layer in layers if layer.kind == "eyeshadow"]
    for layer in layers:
        assert layer.product == product("#B4602E", "satin", KINDS[layer.kind].part)


def test_a_row_keeps_the_part_that_an_option_gives_too(folder):
    (folder / "shades.csv").write_text(TABLE + "Bo,P,eyeliner,Ink,#203040\n")
    for quiet in ([], ["-q"]):
        done = run("in.jpg", "--catalogue", "shades.csv", "--liner", "black:matte",
                   "-o", "{brand}-{shade}.jpg", "-y", *quiet)  # fmt: skip
        assert done.exit_code == 0, done.stderr
        line = (
            "shades.csv: 1 of 3 rows not changed by --liner, since they are for the liner: Bo-Ink\n"
        )
        assert (line in done.stderr) == (not quiet)
    options = LooksOptions(catalogue="shades.csv", liner="black:matte", finish="gloss")
    worn = [
        {layer.kind: layer.product.hex for layer in row.load(True).layers}
        for row in options.wanted(quiet=True)
    ]
    black = {"eyeliner": "#000000"}
    assert worn == [
        {"lipstick": "#B4002E"} | black, {"eyeshadow": "#6B7475"} | black, {"eyeliner": "#203040"},
    ]  # fmt: skip


def test_an_option_for_eyes_needs_a_row_for_eyes(folder):
    done = run("in.jpg", "--catalogue", "shades.csv", "--where", "brand=A", "--zone", "outer",
               "-o", "{look}.jpg")  # fmt: skip
    assert done.exit_code == 2 and "--zone is for eyeshadow" in done.stderr


def test_an_unreadable_row_is_named_with_its_line(folder):
    (folder / "shades.csv").write_text(TABLE + "C,P,lips,Bad,#GG0000\n")
    done = run("in.jpg", "--catalogue", "shades.csv", "-o", "{look}.jpg")
    assert done.exit_code == 2 and "CatalogueError: shades.csv, line 4: hex must be" in done.stderr


def test_rows_that_are_left_out_are_told_unless_quiet(folder):
    (folder / "shades.csv").write_text(TABLE + "C,P,mascara,Black,#000000\nC,P,nail,Red,#F00\n")
    for quiet in ([], ["-q"]):
        done = run(
            "in.jpg", "--catalogue", "shades.csv", "-o", "{product}-{shade}.jpg", "-y", *quiet
        )
        assert done.exit_code == 0 and (folder / "P-Dusk.jpg").exists()
        line = "shades.csv: 2 of 4 rows left out, since they are for no part that is painted: "
        assert (line + "mascara and nail\n" in done.stderr) == (not quiet)


def test_rows_that_go_to_the_lips_unasked_are_told(folder):
    (folder / "shades.csv").write_text(TABLE + "C,P,pencil,Black,#000000\nC,P,,Rose,#F0A0A0\n")
    for quiet in ([], ["-q"]):
        done = run("in.jpg", "--catalogue", "shades.csv", "-o", "{shade}.jpg", "-y", *quiet)
        assert done.exit_code == 0 and (folder / "Black.jpg").exists()
        line = "shades.csv: 1 of 4 rows painted on the lips, since their category names no part: "
        assert (line + "pencil\n" in done.stderr) == (not quiet)


def test_looks_of_one_name_are_numbered():
    names = [one.fields["look"] for one in LooksOptions(look=["a.json", "b/a.json"]).wanted()]
    assert names == ["a", "a-2"]


def test_no_look_at_all_is_refused_as_before():
    (wanted,) = LooksOptions().wanted()
    with pytest.raises(UsageError, match="no look given: add ref='PHOTO'"):
        wanted.load(True)


def report(name, **values):
    return name, Report("in", name, "h264", frames_in=3, frames_out=3, seconds=2.0, **values)


def test_common_warnings_are_printed_once(capsys):
    dropped = {"dropped": ["audio #1"]}
    print_outcomes([report("a", **dropped), report("b", converted=["x"], **dropped)], "in", False)
    assert capsys.readouterr().err.splitlines() == [
        "dropped: audio #1", "b: changed: x", "a: 3 frames, 0.0 kB", "b: 3 frames, 0.0 kB",
        "2 of 2 looks of in in 2.0 s",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("outcomes", "code"),
    [
        ([report("a"), ("b", OutputError("disk full"))], 5),
        ([("a", OutputError("disk full")), ("b", OutputError("disk full"))], 4),
        ([report("a"), report("b", damaged=True)], 5),
    ],
)
def test_a_look_that_failed_shows_in_the_exit_code(outcomes, code, capsys):
    with pytest.raises(Exit) as caught:
        print_outcomes(outcomes, "in", True)
    assert caught.value.exit_code == code
    failed = [name for name, one in outcomes if isinstance(one, OutputError)]
    assert [f"{name}: OutputError: disk full" for name in failed] == [
        line for line in capsys.readouterr().err.splitlines() if "Error" in line
    ]


def test_progress_names_video_and_looks():
    heard = []
    names = {Path(name): name for name in "abcd"}
    tick = titled(lambda *figures, title: heard.append((figures, title)), "x/in.mp4", names)
    tick([Path("a"), Path("b")], 3, 9, 30)
    assert heard == [((3, 9, 30), "in.mp4: a and b")]
    assert titled(None, "in.mp4", names) is None
