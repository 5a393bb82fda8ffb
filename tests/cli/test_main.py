"""The command line, as a real process where running it in this one is not enough."""

import json
import os
import pty
import re
import resource
import signal
import subprocess
import sys
import time

import pytest
from makeup_video.cli import console, main
from makeup_video.cli.app import app
from media import damage, decoded, make_clip
from typer.testing import CliRunner

LOOK = {
    "version": 1, "eyes": None,
    "lips": {"red": 180, "green": 0, "blue": 46, "opacity": 0.8, "gloss": 0.6,
             "gloss_roughness": 0.4, "reflection": 0.2},
}  # fmt: skip


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    make_clip(tmp_path / "in.mp4", audio="aac")
    return tmp_path


@pytest.fixture(scope="module")
def long_clip(tmp_path_factory):
    return make_clip(
        tmp_path_factory.mktemp("long") / "long.mp4", frames=400, size_wh=(640, 360), audio="aac"
    )


def run(*args):
    return CliRunner().invoke(app, [str(arg) for arg in args])


def command(*args, **options):
    """The real command in its own process."""
    words = [sys.executable, "-m", "makeup_video.cli", *map(str, args)]
    return subprocess.Popen(
        words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        **options,
    )  # fmt: skip


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
    ("args", "code", "says"),
    [
        (["no.mp4", "--look", "none", "-o", "out.mp4"], 3, "InputError: no.mp4 does not exist"),
        (
            ["in.mp4", "-o", "out.mp4"],
            2,
            "UsageError: no look given: add --look FILE.json, --color",
        ),
        (["in.mp4", "--ref", "a.jpg", "-o", "out.mp4"], 3, "InputError: a.jpg does not exist"),
        (["in.mp4", "--ref", "in.mp4", "-o", "out.mp4"], 3, "PhotoError: in.mp4 is a video"),
        (["in.mp4", "--ref", "look.json", "-o", "out.mp4"], 3, "look.json is no photo that can"),
        (["in.mp4", "--ref", "a.jpg", "--look", "none", "-o", "o.mp4"], 2, "leave one of them out"),
        (["in.mp4", "--ref-face", "0", "--look", "none", "-o", "o.mp4"], 2, "add --ref PHOTO"),
        (["in.mp4", "--ref", "a.jpg", "--ref-face", "x", "-o", "o.mp4"], 2, "must be largest, or"),
        (["in.mp4", "--look", "no.json", "-o", "out.mp4"], 2, "LookError: no.json"),
        (["in.mp4", "--look", "bad.json", "-o", "out.mp4"], 2, "lips.glos"),
        (
            ["in.mp4", "--finish", "gloss", "-o", "out.mp4"],
            2,
            "needs a colour: add --color '#B4002E', --ref PHOTO",
        ),
        (["in.mp4", "--color", "red", "-o", "out.mp4"], 2, "3 or 6 hex digits such as '#B4002E'"),
        (["in.mp4", "--color", "B02", "--finish", "x", "-o", "out.mp4"], 2, "--finish must be"),
        (["in.mp4", "--color", "B02", "--parts", "nose", "-o", "out.mp4"], 2, "--parts must be"),
        (["in.mp4", "--color", "B02", "--zone", "lid", "-o", "out.mp4"], 2, "no eyes are painted"),
        (["in.mp4", "--color", "B02", "--strength", "2", "-o", "out.mp4"], 2, "--strength must be"),
        (["in.mp4", "--color", "B02", "--strength", "nan", "-o", "o.mp4"], 2, "--strength must be"),
        (["in.mp4", "--color", "B02", "--faces", "me", "-o", "out.mp4"], 2, "--faces must be all"),
        (["in.mp4", "--color", "B02", "--device", "none such", "-o", "out.mp4"], 2, "there is: 0 "),
        (["in.mp4", "--look", "look.json", "--parts", "eyes", "-o", "out.mp4"], 2, "leaves bare"),
        (["in.mp4", "--look", "none", "-o", "in.mp4"], 2, "output is the input"),
        (["in.mp4", "--look", "none", "-o", "in.mp4", "-y"], 2, "output is the input"),
        (["in.mp4", "--look", "none", "-o", "old.mp4"], 2, "exists already"),
        (["in.mp4", "--look", "none", "-o", "out.xyz"], 2, "must end in"),
        (["in.mp4", "--look", "none", "-o", "no/out.mp4"], 4, "OutputError: the folder no"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--codec", "x"], 2, "--codec must be"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--crf", "99"], 2, "--crf must be in 0..51"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--preset", "x"], 2, "--preset must be"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--start", "abc"], 2, "--start must be"),
        (["in.mp4", "--look", "none", "-o", "out.mp4", "--start", "1:99"], 2, "60 or more"),
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
def test_mistakes_are_one_line_and_the_documented_exit_code(folder, args, code, says):
    (folder / "look.json").write_text(json.dumps(LOOK))
    (folder / "bad.json").write_text(json.dumps({**LOOK, "lips": {**LOOK["lips"], "gloss": -1}}))
    (folder / "old.mp4").write_text("precious")
    says = "lips.gloss must be" if says == "lips.glos" else says
    before = (folder / "in.mp4").read_bytes()
    result = run(*args)
    assert result.exit_code == code, result.output
    lines = [line for line in result.output.splitlines() if "Error" in line]
    assert len(lines) == 1 and says in lines[0]
    assert "Traceback" not in result.output
    assert (folder / "in.mp4").read_bytes() == before
    assert (folder / "old.mp4").read_text() == "precious"
    assert not list(folder.glob("*.part.*"))


@pytest.mark.parametrize(
    "args",
    [["in.mp4", "--lok", "none", "-o", "out.mp4"], ["in.mp4", "--look", "none"], ["--look"],
     ["in.mp4", "--look", "none", "-o", "out.mp4", "--crf", "abc"], ["a", "b", "-o", "c"]],
)  # fmt: skip
def test_wrong_options_are_one_line_too(folder, args):
    process = command(*args)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 2
    assert len(said.splitlines()) == 1 and said.startswith("UsageError: ")


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


@pytest.mark.parametrize("stderr", ["closed", "full", "broken pipe"])
def test_nobody_listening_is_no_reason_to_fail(folder, long_clip, stderr):
    words = [sys.executable, "-m", "makeup_video.cli", str(long_clip), "--look", "none"]
    words += ["-o", "out.mp4"]
    line = " ".join(f"'{word}'" for word in words)
    tail = {"closed": "2>&-", "full": "2>/dev/full", "broken pipe": "2>&1 | true"}[stderr]
    script = f"set -o pipefail; {line} {tail}"
    done = subprocess.run(["bash", "-c", script], check=False, stdin=subprocess.DEVNULL)
    assert done.returncode == 0
    assert len(decoded(folder / "out.mp4")) == 400


def test_a_second_ctrl_c_does_not_cost_the_part_file(folder, long_clip):
    process = command(long_clip, "--look", "none", "-o", "out.mp4", "--preset", "slow")
    part = folder / "out.part.mp4"
    deadline = time.monotonic() + 30
    while not (part.exists() and part.stat().st_size > 20000) and time.monotonic() < deadline:
        time.sleep(0.01)
    for _ in range(3):
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 130
    assert said.splitlines()[-1].startswith("stopped")
    assert len(decoded(part)) > 0


def test_a_busy_thread_keeps_neither_process_nor_exit_code():
    """Such a thread reads a large photo that a page sent."""
    code = (
        "import time; from makeup_video.cli import main\n"
        "from makeup_video.web.worker import Worker\n"
        "worker = Worker(); worker.submit(lambda: time.sleep(600)); worker.stop(); main._exit(5)"
    )
    assert subprocess.run([sys.executable, "-c", code], timeout=60, check=False).returncode == 5


def test_ctrl_c_keeps_its_exit_code_while_python_compiles():
    """Python remembers such an interruption, and would otherwise end by the signal."""
    code = (
        "import sys, types; from makeup_video.cli import main\n"
        "def app(**_): exec('raise KeyboardInterrupt')\n"
        "sys.modules['makeup_video.cli.app'] = types.SimpleNamespace(app=app); main.main()"
    )
    assert subprocess.run([sys.executable, "-c", code], timeout=60, check=False).returncode == 130


@pytest.mark.parametrize("delay", [0.15, 0.25, 0.4])
def test_an_early_ctrl_c_is_one_line(folder, long_clip, delay):
    process = command(long_clip, "--look", "none", "-o", "out.mp4")
    time.sleep(delay)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=30)
    if process.returncode == -signal.SIGINT or "site.py" in said or "runpy" in said:
        pytest.skip("it came before Python had begun to run our code")
    assert process.returncode == 130
    assert len(said.splitlines()) == 1 and said.startswith("stopped")


def test_the_progress_counts_only_what_the_trim_keeps(folder):
    from fractions import Fraction

    from makeup_video.pipeline import Settings, process_video

    src, seen = make_clip(folder / "long.mp4", frames=300), []
    settings = Settings(start_seconds=Fraction(2), end_seconds=Fraction(5))
    process_video(
        src, folder / "o.mp4", None, settings, lambda d, expected, r: seen.append(expected)
    )
    assert set(seen) <= {90}


def test_unknown_options_are_a_usage_error(folder):
    assert run("in.mp4", "--lok", "none", "-o", "out.mp4").exit_code == 2


def test_debug_adds_the_traceback(folder):
    process = command("no.mp4", "--look", "none", "-o", "out.mp4", "--debug")
    assert "Traceback" in process.communicate(timeout=60)[1] and process.returncode == 3


def test_a_look_file_that_paints_nothing_is_carried_out(folder):
    (folder / "look.json").write_text(json.dumps({**LOOK, "strength": 0}))
    assert run("in.mp4", "--look", "look.json", "-o", "out.mp4").exit_code == 0


def test_quiet_prints_nothing(folder):
    result = run("in.mp4", "--look", "none", "-o", "out.webm", "--quiet")
    assert (result.exit_code, result.output) == (0, "")


@pytest.mark.parametrize("codec", ["h264", "hevc", "av1", "vp9"])
def test_no_encoder_prints_on_its_own(folder, codec):
    end = ".webm" if codec == "vp9" else ".mp4"
    process = command("in.mp4", "--look", "none", "-o", f"out{end}", "--codec", codec)
    out, said = process.communicate(timeout=60)
    lines = [line for line in said.splitlines() if not line.startswith("changed: ")]
    assert out == "" and len(lines) == 1 and lines[0].startswith(f"out{end}: 12 frames")


def test_what_changed_is_said_line_by_line(folder):
    result = run("in.mp4", "--look", "none", "-o", "out.webm")
    assert "changed: audio #1 (aac) -> libopus" in result.output.splitlines()


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


def test_damaged_input_is_done_as_far_as_possible(folder):
    damage(make_clip(folder / "long.mp4", frames=60, size_wh=(320, 240)))
    for quiet in ([], ["-q"]):
        result = run("long.mp4", "--look", "none", "-o", "out.mp4", "-y", *quiet)
        assert result.exit_code == 5, result.output
        assert "the input is damaged: " in result.output
        assert len(decoded(folder / "out.mp4")) > 30


def test_trimming_reads_seconds_and_clock_times(folder):
    make_clip(folder / "long.mp4", frames=90)
    for start, end in (("1", "2"), ("0:01", "00:00:02.0"), ("1.0", "0:2")):
        result = run(
            "long.mp4", "--look", "none", "-o", "out.mp4", "-y", "--start", start, "--end", end
        )
        assert result.exit_code == 0
        assert len(decoded(folder / "out.mp4")) == 30


@pytest.mark.parametrize("name", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("end", [".mp4", ".mkv", ".webm"])
def test_ctrl_c_leaves_a_playable_part_within_two_seconds(folder, long_clip, name, end):
    slow = [] if end == ".webm" else ["--preset", "slow"]
    process = command(long_clip, "--look", "none", "-o", f"out{end}", *slow)
    part = folder / f"out.part{end}"
    deadline = time.monotonic() + 30
    while not (part.exists() and part.stat().st_size > 20000) and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(name)
    began = time.monotonic()
    _, said = process.communicate(timeout=30)
    assert time.monotonic() - began < 2
    assert process.returncode == 130
    assert said.splitlines()[-1] == f"stopped; out.part{end} holds what was done"
    assert not (folder / f"out{end}").exists()
    assert 0 < len(decoded(part)) < 400


def test_a_full_disk_is_one_line_and_leaves_no_file(folder, long_clip):
    """A limit on the size of files stands for a full disk; the error is much the same."""

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

    process = command(long_clip, "--look", "none", "-o", "out.mp4", preexec_fn=limit)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 4
    assert said.startswith("OutputError: out.part.mp4 cannot be written: ")
    assert len(said.splitlines()) == 1
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
        _, said = process.communicate(timeout=60)
        assert process.returncode == 4
        assert "No space left on device" in said and len(said.splitlines()) == 1
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


def test_on_a_terminal_a_bar_shows_frames_speed_and_time_left(folder, long_clip):
    leader, follower = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "makeup_video.cli", str(long_clip), "--look", "none",
         "-o", "out.mp4"],
        stderr=follower, stdout=follower, stdin=follower,
        env={**os.environ, "TERM": "xterm-256color", "COLUMNS": "100"},
    )  # fmt: skip
    os.close(follower)
    shown = b""
    while True:
        try:
            piece = os.read(leader, 4096)
        except OSError:
            break
        if not piece:
            break
        shown += piece
    os.close(leader)
    assert process.wait(30) == 0
    text = re.sub(rb"\x1b\[[0-9;?]*[A-Za-z]", b"", shown).decode()
    assert "/400" in text and " fps" in text and "x real time" in text
    assert text.rstrip().splitlines()[-1].startswith("out.mp4: 400 frames in")


def test_elsewhere_a_plain_line_now_and_then(monkeypatch, capsys):
    from fractions import Fraction

    from makeup_video.cli import progress

    clock = iter([0.0, 1.0, 6.0, 7.0, 12.0])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
    lines = progress._PlainLines()
    for done in (30, 180, 200, 360):
        lines(done, 600, Fraction(30))
    assert capsys.readouterr().err.splitlines() == [
        "180/600 frames, 30 fps, 1.0x real time, 0:14 left",
        "360/600 frames, 30 fps, 1.0x real time, 0:08 left",
    ]


def test_nothing_heavy_is_imported_before_it_is_needed():
    """A quick start: --help loads no OpenCV, no ONNX Runtime, no OpenCL and no rich."""
    code = (
        "import sys; from makeup_video.cli.app import app\n"
        "heavy = {'cv2', 'onnxruntime', 'pyopencl', 'av', 'numpy'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "import makeup_video.pipeline\n"
        "heavy = {'cv2', 'onnxruntime', 'pyopencl', 'rich.progress'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_ctrl_c_raised_as_another_error_is_still_a_stop(monkeypatch, capsys):
    """This happens while a C module is being loaded."""
    ended = []

    def app(**_):
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise ImportError("initialization failed") from None

    monkeypatch.setattr("makeup_video.cli.app.app", app)
    monkeypatch.setattr(main, "_exit", ended.append)
    monkeypatch.setattr(main, "_came", [])
    monkeypatch.setattr(console, "_lines", 0)
    before = {
        name: signal.getsignal(name) for name in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    }
    try:
        main.main()
    finally:
        for name, handler in before.items():
            signal.signal(name, handler)
    assert ended == [130] and capsys.readouterr().err == "stopped\n"
