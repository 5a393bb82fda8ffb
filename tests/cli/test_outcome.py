"""How a command ends: its exit code and its last lines."""

import json
import os
import resource
import subprocess
import sys

import pytest
import typer
from command_line import LIPSTICK, LOOK, command, run
from makeup_video.cli.app import app
from makeup_video.cli.outcome import report_errors, some_of
from makeup_video.pipeline import SeveralFacesError
from media import damage, decoded, make_clip


@pytest.mark.parametrize(
    ("args", "code", "message"),
    [
        (["no.mp4", "--look", "none", "-o", "out.mp4"], 3, "InputError: no.mp4 does not exist"),
        (
            ["in.mp4", "-o", "out.mp4"],
            2,
            "UsageError: no look given: add --ref PHOTO, --look NAME",
        ),
        (["in.mp4", "--ref", "a.jpg", "-o", "out.mp4"], 3, "InputError: a.jpg does not exist"),
        (["in.mp4", "--ref", "in.mp4", "-o", "out.mp4"], 3, "PhotoError: in.mp4 is a video"),
        (
            ["in.mp4", "--ref", "look.json", "-o", "out.mp4"],
            2,
            "look.json is a look: use --look look.json",
        ),
        (["in.mp4", "--ref", "a.jpg", "--look", "none", "-o", "o.mp4"], 2, "2 looks need a name"),
        (["in.mp4", "--ref-face", "0", "--look", "none", "-o", "o.mp4"], 2, "add --ref PHOTO"),
        (["in.mp4", "--ref", "a.jpg", "--ref-face", "x", "-o", "o.mp4"], 2, "must be largest, or"),
        (["in.mp4", "--look", "no.json", "-o", "out.mp4"], 2, "LookError: no.json"),
        (["in.mp4", "--look", "bad.json", "-o", "out.mp4"], 2, "layers[0].product.gloss must be"),
        (["in.mp4", "--look", "old.json", "-o", "out.mp4"], 2, "lips.gloss must be"),
        (["in.mp4", "--look", "cateye2", "-o", "out.mp4"], 2, "did you mean cat-eye?"),
        (["in.mp4", "--lips", "red:gloss:matte", "-o", "out.mp4"], 2, "--lips gives the finish"),
        (
            ["in.mp4", "--finish", "gloss", "-o", "out.mp4"],
            2,
            "needs a colour: add --color '#B4002E', --ref PHOTO",
        ),
        (
            ["in.mp4", "--color", "rot", "-o", "out.mp4"],
            2,
            "--color must be a colour such as '#B4002E'",
        ),
        (["in.mp4", "--color", "B02", "--finish", "x", "-o", "out.mp4"], 2, "--finish must be"),
        (["in.mp4", "--color", "B02", "--parts", "nose", "-o", "out.mp4"], 2, "--parts must be"),
        (["in.mp4", "--color", "B02", "--zone", "lid", "-o", "out.mp4"], 2, "no eyes are painted"),
        (["in.mp4", "--color", "B02", "--strength", "2", "-o", "out.mp4"], 2, "--strength must be"),
        (["in.mp4", "--color", "B02", "--strength", "nan", "-o", "o.mp4"], 2, "--strength must be"),
        (["in.mp4", "--color", "B02", "--faces", "me", "-o", "out.mp4"], 2, "--faces must be all"),
        (["in.mp4", "--color", "B02", "--device", "foo", "-o", "out.mp4"], 2, "--device: an "),
        (["in.mp4", "--look", "look.json", "--parts", "eyes", "-o", "out.mp4"], 2, "leaves bare"),
        (["in.mp4", "--look", "none", "-o", "in.mp4"], 2, "output is the input"),
        (["in.mp4", "--look", "none", "-o", "in.mp4", "-y"], 2, "output is the input"),
        (["in.mp4", "--look", "none", "-o", "old.mp4"], 2, "exists already"),
        (["in.mp4", "--look", "none", "-o", "out.xyz"], 2, "--output must end in .mp4, "),
        (["in.mp4", "--look", "none", "-o", ".mp4"], 2, "got '.mp4' without a name before it"),
        (["in.mp4", "--look", "none", "-o", "no/out.mp4"], 4, "OutputError: the folder no"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--codec", "x"], 2, "--codec must be"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--crf", "99"], 2, "--crf must be in 0..51"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--preset", "x"], 2, "--preset must be"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--start", "abc"], 2, "--start must be"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--start", "1:99"], 2, "must be below 60"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--end", "0"], 2, "--end later"),
        (["in.mp4", "--look", "none", "-o", "out.webm", "--strict"], 6, "StrictError: --strict"),
        (
            ["in.mp4", "--look", "none", "-o", "out.mp4", "--report", "no/r.json"],
            4,
            "the folder no does",
        ),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--report", "."], 4, "is a folder"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--report", "old.mp4"], 2, "add -y"),
    ],
)
def test_mistakes_are_one_line_and_the_documented_exit_code(folder, args, code, message):
    (folder / "look.json").write_text(json.dumps(LOOK))
    shiny = {**LIPSTICK, "gloss": -1}
    layers = [{"kind": "lipstick", "product": shiny}]
    (folder / "bad.json").write_text(json.dumps({**LOOK, "layers": layers}))
    (folder / "old.json").write_text(json.dumps({"version": 1, "lips": shiny, "eyes": None}))
    (folder / "old.mp4").write_text("precious")
    before = (folder / "in.mp4").read_bytes()
    result = run(*args)
    assert result.exit_code == code, result.output
    lines = [line for line in result.output.splitlines() if "Error" in line]
    assert len(lines) == 1 and message in lines[0]
    assert lines[0].endswith(" See makeup-video --help.") == lines[0].startswith("UsageError: ")
    assert "Traceback" not in result.output
    assert (folder / "in.mp4").read_bytes() == before
    assert (folder / "old.mp4").read_text() == "precious"
    assert not list(folder.glob("*.part.*"))


@pytest.mark.parametrize("stderr", ["closed", "full", "broken pipe"])
def test_a_run_succeeds_though_stderr_cannot_be_written(folder, stderr):
    words = [sys.executable, "-m", "makeup_video.cli", "in.mp4", "--look", "none", "-o", "out.mp4"]
    line = " ".join(f"'{word}'" for word in words)
    tail = {"closed": "2>&-", "full": "2>/dev/full", "broken pipe": "2>&1 | true"}[stderr]
    script = f"set -o pipefail; {line} {tail}"
    done = subprocess.run(["bash", "-c", script], check=False, stdin=subprocess.DEVNULL)
    assert done.returncode == 0
    assert len(decoded(folder / "out.mp4")) == 12


def test_of_several_faces_each_command_advises_what_it_has(capsys):
    for name, group in typer.main.get_command(app).commands.items():
        options = {word for param in group.params for word in param.opts}
        if not {"--ref", "--ref-face"} & options:
            continue
        with pytest.raises(typer.Exit) as end, report_errors(name):
            raise SeveralFacesError("2 were found: give a photo of one")
        assert end.value.exit_code == 3
        line = capsys.readouterr().err
        assert ("--ref-face NUMBER or" in line) == ("--ref-face" in options), name
        assert line.startswith("SeveralFacesError: 2 were found: give a photo of one, or ")


def test_debug_adds_the_traceback(folder):
    process = command("no.mp4", "--look", "none", "-o", "out.mp4", "--debug")
    assert "Traceback" in process.communicate(timeout=60)[1] and process.returncode == 3


def test_each_change_is_printed_on_its_own_line(folder):
    result = run("in.mp4", "--look", "none", "-o", "out.webm")
    assert "changed: audio #1 (aac) -> libopus" in result.output.splitlines()


def test_damaged_input_is_done_as_far_as_possible(folder):
    damage(make_clip(folder / "long.mp4", frames=60, size_wh=(320, 240)))
    for quiet in ([], ["-q"]):
        result = run("long.mp4", "--look", "none", "-o", "out.mp4", "-y", *quiet)
        assert result.exit_code == 5, result.output
        assert "the input is damaged: " in result.output
        assert len(decoded(folder / "out.mp4")) > 30


def test_a_full_disk_is_one_line_and_leaves_no_file(folder, long_clip):
    """A limit on file sizes stands in for a full disk; the error is almost the same."""

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

    process = command(long_clip, "--look", "none", "-o", "out.mp4", preexec_fn=limit)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 4
    assert stderr.startswith("OutputError: out.part.mp4 cannot be written: ")
    assert len(stderr.splitlines()) == 1
    assert sorted(path.name for path in folder.iterdir()) == ["in.mp4"]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may mount a small file system")
@pytest.mark.parametrize("end", [".mp4", ".mkv"])
def test_a_really_full_disk(folder, long_clip, end):
    (folder / "small").mkdir()
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=200k", "none", "small"], check=False
    ).returncode:
        pytest.skip("mounting is not allowed here; the test above limits the file instead")
    try:
        process = command(long_clip, "--look", "none", "-o", f"small/out{end}")
        _, stderr = process.communicate(timeout=60)
        assert process.returncode == 4
        assert "No space left on device" in stderr and len(stderr.splitlines()) == 1
        assert list((folder / "small").iterdir()) == []
    finally:
        subprocess.run(["umount", "small"], check=True)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_write_permission(folder):
    (folder / "locked").mkdir(mode=0o500)
    result = run("in.mp4", "--look", "none", "-o", "locked/out.mp4")
    assert result.exit_code == 4 and "cannot be written" in result.output


def test_a_read_only_folder_is_refused_even_for_root(folder):
    """Nobody can create a file in /proc."""
    result = run("in.mp4", "--look", "none", "-o", "/proc/out.mp4")
    assert result.exit_code == 4
    assert len(result.output.splitlines()) == 1 and "cannot be written" in result.output


def test_of_many_names_a_line_has_three_at_most():
    assert some_of("ab") == "a and b" and some_of("abc") == "a, b and c"
    assert some_of("abcd") == "a, b and 2 more"
