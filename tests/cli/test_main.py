"""The command line, run in-process where possible and as a real process otherwise."""

import json
import os
import re
import subprocess
import sys

import pytest
from command_line import LOOK, command, run
from media import decoded, make_clip


@pytest.mark.parametrize(
    "args",
    [
        ["in.mp4", "--look", "none", "-o", "out.mp4"],
        ["--look", "none", "-o", "out.mp4", "in.mp4"],
        ["-o", "out.mp4", "in.mp4", "--look=none"],
        ["apply", "in.mp4", "--look", "none", "--output", "out.mp4"],
    ],
)
def test_the_bare_form_needs_no_command_name(folder, args):
    result = run(*args)
    assert result.exit_code == 0, result.output
    assert len(decoded(folder / "out.mp4")) == 12
    assert re.search(r"^out.mp4: 12 frames in .* fps, .*x real time\), .* kB$", result.output)


@pytest.mark.parametrize("name", ["live", "apply", "bench"])
@pytest.mark.parametrize("form", ["path", "options first", "apply"])
def test_a_file_may_be_named_like_a_command(folder, name, form):
    (folder / "in.mp4").rename(folder / name)
    rest = ["--look", "none", "-o", "out.mp4"]
    args = {
        "path": [f"./{name}", *rest],
        "options first": [*rest, name],
        "apply": ["apply", name, *rest],
    }[form]
    assert run(*args).exit_code == 0
    assert (folder / "out.mp4").exists()


def test_help_and_version_belong_to_the_group():
    assert "Exit codes: 0 done" in " ".join(run("--help").output.split())
    assert re.match(r"makeup-video \d+\.\d+", run("--version").output)
    assert run().exit_code == 2 and "Usage" in run().output
    assert "--look" in run("apply", "--help").output


@pytest.mark.parametrize(
    "args",
    [["in.mp4", "--lok", "none", "-o", "out.mp4"], ["in.mp4", "--look", "none"], ["--look"],
     ["in.mp4", "--look", "none", "-o", "out.mp4", "--crf", "abc"], ["a", "b", "-o", "c"]],
)  # fmt: skip
def test_wrong_options_are_one_line(folder, args):
    process = command(*args)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 2
    assert len(stderr.splitlines()) == 1 and stderr.startswith("UsageError: ")


@pytest.mark.parametrize(
    "name",
    ["in.mp4", "out.mp4", "look.json", "out.part.mp4", "hard.json", "soft.json", "hard_look.json"],
)
def test_the_report_never_takes_the_place_of_another_file(folder, name):
    (folder / "look.json").write_text(json.dumps({**LOOK, "strength": 0}))
    os.link("in.mp4", "hard.json")
    os.link("look.json", "hard_look.json")
    os.symlink("in.mp4", "soft.json")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = run("in.mp4", "--look", "look.json", "-o", "out.mp4", "--report", name, "-y")
    assert result.exit_code == 2
    assert f"the report {name} is one of this run's own files" in result.output
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_an_old_report_is_overwritten_only_with_yes(folder):
    words = ["in.mp4", "--look", "none", "-o", "out.mp4", "--report", "r.json"]
    (folder / "r.json").write_text("old")
    assert run(*words).exit_code == 2
    assert not (folder / "out.mp4").exists()
    assert run(*words[:4], "out.webm", "--report", "r.json", "-y", "--strict").exit_code == 6
    assert (folder / "r.json").read_text() == "old"
    assert run(*words, "-y").exit_code == 0
    assert json.loads((folder / "r.json").read_text())["frames_out"] == 12
    assert sorted(path.name for path in folder.iterdir()) == ["in.mp4", "out.mp4", "r.json"]


@pytest.mark.parametrize("text", ["1e3", "-1", "1/2", "", "99999999999999999999", "1:2:3:4", "inf"])
def test_times_are_plain_numbers(folder, text):
    result = run("in.mp4", "--look", "none", "-o", "out.mp4", f"--start={text}")
    assert result.exit_code == 2 and "--start must be" in result.output


def test_unknown_options_are_a_usage_error(folder):
    assert run("in.mp4", "--lok", "none", "-o", "out.mp4").exit_code == 2


def test_a_look_file_that_paints_nothing_is_accepted(folder):
    (folder / "look.json").write_text(json.dumps({**LOOK, "strength": 0}))
    assert run("in.mp4", "--look", "look.json", "-o", "out.mp4").exit_code == 0


def test_quiet_prints_nothing(folder):
    result = run("in.mp4", "--look", "none", "-o", "out.webm", "--quiet")
    assert (result.exit_code, result.output) == (0, "")


@pytest.mark.parametrize("codec", ["h264", "hevc", "av1", "vp9"])
def test_no_encoder_prints_lines_of_its_own(folder, codec):
    end = ".webm" if codec == "vp9" else ".mp4"
    process = command("in.mp4", "--look", "none", "-o", f"out{end}", "--codec", codec)
    out, stderr = process.communicate(timeout=60)
    lines = [line for line in stderr.splitlines() if not line.startswith("changed: ")]
    assert out == "" and len(lines) == 1 and lines[0].startswith(f"out{end}: 12 frames")


def test_the_report_is_json_with_every_promised_figure(folder):
    assert run("in.mp4", "--look", "none", "-o", "out.mp4", "--report", "r.json").exit_code == 0
    report = json.loads((folder / "r.json").read_text())
    assert report["frames_in"] == report["frames_out"] == 12
    assert report["max_pts_error_seconds"] == 0
    for key in ("dropped", "converted", "conversions", "corrupt_frames", "lost_frames", "stages",
                "channels", "bytes_in", "bytes_out", "peak_memory_bytes", "fps"):  # fmt: skip
        assert key in report
    assert list(report["stages"]) == ["decode", "encode"]
    assert report["painted_frames"] is None and report["frames_with_face"] is None


def test_trimming_reads_seconds_and_clock_times(folder):
    make_clip(folder / "long.mp4", frames=90)
    for start, end in (("1", "2"), ("0:01", "00:00:02.0"), ("1.0", "0:2")):
        result = run(
            "long.mp4", "--look", "none", "-o", "out.mp4", "-y", "--start", start, "--end", end
        )
        assert result.exit_code == 0
        assert len(decoded(folder / "out.mp4")) == 30


def test_nothing_heavy_is_imported_before_it_is_needed():
    """--help starts fast: it loads no OpenCV, no ONNX Runtime, no OpenCL and no rich."""
    code = (
        "import sys; from makeup_video.cli.app import app\n"
        "heavy = {'cv2', 'onnxruntime', 'pyopencl', 'av', 'numpy'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "import makeup_video.pipeline\n"
        "heavy = {'cv2', 'onnxruntime', 'pyopencl', 'rich.progress'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


# Prints whether the garbage collector runs once a command works, and whether it skips modules.
SEEKING = """
import gc, sys
from makeup_video.cli import main
from makeup_video.pipeline.engine import machine
from makeup_video.pipeline.reference import estimate

def report(*_):
    print(gc.isenabled(), gc.get_freeze_count() > 10_000, flush=True)
    main.os._exit(0)

machine.return_large_blocks = estimate.estimate_from = report
main.main()
"""


@pytest.mark.parametrize("look", [("--look", "none"), ("--ref", "photo.jpg")])
def test_garbage_is_sought_once_all_is_loaded(folder, look):
    words = [sys.executable, "-c", SEEKING, "in.mp4", *look, "-o", "out.mp4"]
    done = subprocess.run(words, check=True, capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == ["True", "True"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="only Linux has it")
@pytest.mark.parametrize("words", [["--help"], ["-h"], ["--version"], ["apply", "--help"]])
def test_help_that_cannot_be_printed_is_one_line(words):
    with open("/dev/full", "w") as full:
        process = subprocess.run(
            [sys.executable, "-m", "makeup_video.cli", *words],
            check=False, stdout=full, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
    line = (
        "OutputError: stdout cannot be written: No space left on device; free some space, or "
        "choose another disk\n"
    )
    assert (process.returncode, process.stderr) == (4, line)
