"""Ctrl-C at any moment: the exit code, one line, and a part file that plays."""

import contextlib
import gc
import signal
import subprocess
import sys
import time
import types

import pytest
from command_line import command
from makeup_video.cli import console, main
from media import decoded


def test_a_second_ctrl_c_keeps_the_part_file(folder, long_clip):
    process = command(long_clip, "--look", "none", "-o", "out.mp4", "--preset", "slow")
    part = folder / "out.part.mp4"
    deadline = time.monotonic() + 30
    while not (part.exists() and part.stat().st_size > 20000) and time.monotonic() < deadline:
        time.sleep(0.01)
    for _ in range(3):
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
    _, stderr = process.communicate(timeout=30)
    assert process.returncode == 130
    assert stderr.splitlines()[-1].startswith("stopped")
    assert len(decoded(part)) > 0


def test_a_busy_thread_keeps_neither_process_nor_exit_code():
    """A thread that reads a large uploaded photo is busy in this way."""
    code = (
        "import time; from makeup_video.cli import main\n"
        "from makeup_video.web.slow_jobs import SlowJobs\n"
        "slow_jobs = SlowJobs(); slow_jobs.submit(lambda: time.sleep(600)); slow_jobs.stop(); main._exit(5)"
    )
    assert subprocess.run([sys.executable, "-c", code], timeout=60, check=False).returncode == 5


def test_ctrl_c_keeps_its_exit_code_while_python_compiles():
    """Python remembers this interruption, and would otherwise exit by the signal."""
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
    _, stderr = process.communicate(timeout=30)
    if process.returncode == -signal.SIGINT or "KeyboardInterrupt" in stderr:
        # While Python starts, Ctrl-C ends it by the signal or with exit code 1.
        assert ", in main" not in stderr, stderr
        pytest.skip("it came before main")
    assert process.returncode == 130
    assert len(stderr.splitlines()) == 1 and stderr.startswith("stopped")


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
    _, stderr = process.communicate(timeout=30)
    assert time.monotonic() - began < 2
    assert process.returncode == 130
    assert stderr.splitlines()[-1] == f"stopped; out.part{end} holds what was done"
    assert not (folder / f"out{end}").exists()
    assert 0 < len(decoded(part)) < 1600


def test_ctrl_c_names_the_part_of_every_output_of_a_template(folder, long_clip):
    words = ["--look", "none", "--look", "berry", "-o", "{look}.mp4", "--preset", "slow"]
    process = command(long_clip, *words)
    parts = [folder / "none.part.mp4", folder / "berry.part.mp4"]
    deadline = time.monotonic() + 60
    while not all(map(_has_begun, parts)) and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=30)
    assert process.returncode == 130
    last = stderr.splitlines()[-1]
    assert last == "stopped; none.part.mp4 and berry.part.mp4 hold what was done"


def _has_begun(part):
    return part.exists() and part.stat().st_size > 20000


def _ctrl_c_turned_into_an_import_error():
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise ImportError("initialization failed") from None


class _LosesCtrlC(types.ModuleType):
    """A module that hides Ctrl-C while it is imported, as a weak reference's callback does."""

    @property
    def app(self):
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        return lambda **_: 0


def test_ctrl_c_raised_as_another_error_is_still_a_stop(monkeypatch, capsys):
    """This happens while Python loads a C module."""
    app = types.SimpleNamespace(app=lambda **_: _ctrl_c_turned_into_an_import_error())
    _check_it_stops(monkeypatch, capsys, app)


def test_ctrl_c_lost_by_an_import_is_still_a_stop(monkeypatch, capsys):
    """This happens in Python's callbacks that free the locks of modules."""
    _check_it_stops(monkeypatch, capsys, _LosesCtrlC("app"))


def test_ctrl_c_after_a_line_is_still_said(monkeypatch, capsys):
    """Typer turns Ctrl-C into a bare exit code, for example while a photo is read."""

    def app(**_):
        console.log("look.jpg: red lips")
        return 130

    _check_it_stops(monkeypatch, capsys, types.SimpleNamespace(app=app), "look.jpg: red lips\n")


def test_the_end_of_a_stopped_run_is_said_once(monkeypatch, capsys):
    def app(**_):
        console.log_stopped("stopped; out.part.mp4 holds what was done")
        raise KeyboardInterrupt  # a second one, while the run ends

    said = "stopped; out.part.mp4 holds what was done\n"
    _check_it_stops(monkeypatch, capsys, types.SimpleNamespace(app=app), said, "")


def _check_it_stops(monkeypatch, capsys, app_module, before="", last="stopped\n"):
    ended = []
    monkeypatch.setitem(sys.modules, "makeup_video.cli.app", app_module)
    monkeypatch.setattr(main, "_exit", ended.append)
    monkeypatch.setattr(main, "_came", [])
    monkeypatch.setattr(console, "_said_stopped", False)
    handlers = {
        name: signal.getsignal(name) for name in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    }
    try:
        main.main()
    finally:
        gc.enable()  # as `main` found it
        for name, handler in handlers.items():
            signal.signal(name, handler)
    assert ended == [130] and capsys.readouterr().err == before + last
