"""`makeup-video live` with a video as the camera: its outputs, its errors, and its end."""

import io
import re
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from types import SimpleNamespace
from unittest.mock import Mock

import av
import numpy as np
import pytest
from makeup_video.cli.app import app
from makeup_video.cli.console import log
from makeup_video.cli.live import _Sound
from makeup_video.cli.progress import live_summary, live_text, show_live
from makeup_video.cli.serve_page import has_screen
from makeup_video.pipeline import InputError, Look, product
from makeup_video.pipeline.live.run import LiveFigures, SinkFigures
from media import decoded, times_of
from people import SAMPLES, clip, write_video
from typer.testing import CliRunner


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_video(tmp_path / "in.mkv", clip(12))
    return tmp_path


def run(*args):
    return CliRunner().invoke(app, ["live", *(str(arg) for arg in args)])


def lines(done):
    return [line for line in done.output.splitlines() if line]


def reddest(path):
    """Per frame, the highest Cr above neutral, in codes."""
    return [int(picture.to_ndarray()[-90:].max()) - 128 for picture in decoded(path)]


def test_a_video_is_painted_and_recorded_at_clock_times(folder):
    done = run("--camera", "in.mkv", "--color", "#D00020", "--no-preview", "-o", "out.mkv")
    assert done.exit_code == 0, done.output
    assert [p.name for p in folder.iterdir() if "part" in p.name] == []
    times = np.array([float(t) for t in times_of(folder / "out.mkv")])
    summary = r"(\d+) frames in [\d.]+ s, [\d.]+ fps, (\d+) dropped; out.mkv got (\d+) of them.*"
    counts = re.fullmatch(summary, lines(done)[-1])
    assert times[0] == 0 and len(times) == int(counts[1]) == int(counts[3])
    assert len(times) + int(counts[2]) == 12  # a busy machine drops some frames
    steps = times * 30
    assert np.abs(steps - steps.round()).max() < 0.05  # the times of the video's own frames
    plain = run("--camera", "in.mkv", "--look", "none", "--no-preview", "-o", "plain.mkv", "-q")
    assert plain.exit_code == 0 and plain.output == ""
    assert min(reddest(folder / "out.mkv")) > max(reddest(folder / "plain.mkv")) + 10


def test_a_recording_is_only_overwritten_with_y(folder):
    (folder / "out.mkv").write_bytes(b"mine")
    words = "--camera", "in.mkv", "--color", "#D00020", "--no-preview", "-o", "out.mkv"
    refused = run(*words)
    assert refused.exit_code == 2
    assert (folder / "out.mkv").read_bytes() == b"mine" and "-y" in refused.output
    assert run(*words, "-y").exit_code == 0
    assert decoded(folder / "out.mkv")


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (
            ["--camera", "in.mkv", "--color", "#D00020", "--no-preview"],
            2,
            "--no-preview leaves no output",
        ),
        (["--camera", "in.mkv", "--no-preview", "-o", "out.mkv"], 2, "no look given"),
        (["--camera", "in.mkv", "--finish", "gloss"], 2, "--finish gloss needs a colour"),
        (["--camera", "in.mkv", "--look", "a", "--ref", "b"], 2, "leave one of them out"),
        (["--camera", "gone.mkv", "--color", "#D00020"], 3, "gone.mkv does not exist"),
        (["--camera", "in.mkv", "--size", "large"], 2, "WIDTHxHEIGHT"),
        (["--camera", "in.mkv", "--fps", "0"], 2, "1..240"),
        (
            ["--camera", "in.mkv", "--color", "#D00020", "--stream", "file:x"],
            2,
            "--stream must begin",
        ),
        (["--camera", "in.mkv", "--color", "#D00020", "-o", "out.doc"], 2, "--output must end in"),
        (["--camera", "in.mkv", "--color", "#D00020", "-o", "in.mkv", "-y"], 2, "in.mkv"),
    ],
)
def test_mistakes_are_one_line_before_anything_is_written(folder, words, code, message):
    done = run(*words, "--no-browser", "--port", "0")
    assert (done.exit_code, len(lines(done))) == (code, 1), done.output
    assert message in done.output
    assert ("See makeup-video live --help." in done.output) == (code == 2)
    assert sorted(path.name for path in folder.iterdir()) == ["in.mkv"]


def test_a_port_in_use_is_refused_with_advice(folder):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        done = run("--camera", "in.mkv", "--port", port, "--no-browser")
    assert done.exit_code == 2 and f"port {port}" in done.output and "--port" in done.output


@pytest.mark.parametrize("name", ["SIGINT", "SIGHUP"])
def test_ctrl_c_is_the_usual_end_and_the_recording_is_whole(folder, name):
    """Ctrl-C is repeated until the process ends."""
    words = ["live", "--camera", "in.mkv", "--loop", "--color", "#D00020", "-o", "out.mp4"]
    with subprocess.Popen(
        [sys.executable, "-m", "makeup_video.cli", *words, "--port", "0", "--no-browser"],
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
    ) as process:
        url = process.stderr.readline().split()[0]
        with urllib.request.urlopen(url, timeout=20) as page:
            assert page.status == 200
        while not (folder / "out.part.mp4").exists():  # created with the first picture
            assert process.poll() is None
            time.sleep(0.02)
        while process.poll() is None:
            process.send_signal(getattr(signal, name))
            time.sleep(0.02)
        rest = process.stderr.read()
    assert process.returncode == 0, rest
    assert " dropped; out." in rest and len(rest.splitlines()) == 1
    with av.open(str(folder / "out.mp4")) as whole:
        assert sum(1 for _ in whole.decode(video=0)) >= 1


def test_without_a_look_the_page_begins_bare(folder):
    done = run("--camera", "in.mkv", "--port", "0", "--no-browser")
    assert done.exit_code == 0 and "shows the page" in done.output
    done = run("--camera", "in.mkv", "--port", "0", "--no-browser", "--ref", SAMPLES / "look.jpg")
    assert done.exit_code == 0 and "lips #" in done.output


def test_the_look_that_options_change_is_described(folder):
    words = [
        "--camera",
        "in.mkv",
        "-o",
        "out.mkv",
        "-y",
        "--no-preview",
        "--ref",
        SAMPLES / "look.jpg",
    ]
    changed = run(*words, "--lips", "berry:matte").output
    assert "painted: lips #9D354F, matte" in changed
    assert "painted: " not in run(*words).output


def test_a_page_open_to_the_network_is_announced_as_one(folder):
    done = run("--camera", "in.mkv", "--port", "0", "--no-browser", "--host", "0.0.0.0")
    assert done.exit_code == 0 and "everybody who reaches this machine" in done.output


@pytest.mark.parametrize(
    ("host", "warns"),
    [("127.8.0.1", False), ("LOCALHOST", False), ("localhost.", False), ("0", True)],
)
def test_a_page_is_open_to_others_by_its_bound_address(folder, host, warns):
    done = run("--camera", "in.mkv", "--port", "0", "--no-browser", "--host", host)
    assert done.exit_code == 0 and ("everybody who reaches" in done.output) is warns


def test_no_browser_opens_without_a_display(monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert not has_screen()
    monkeypatch.setenv("DISPLAY", ":0")
    assert has_screen()


def figures(**given):
    plain = {"fps": 29.97, "latency_ms": 12.4, "pictures": 300, "dropped": 0, "damaged": 0,
             "level": 0, "level_notice": "", "notice": "", "sinks": ()}  # fmt: skip
    return LiveFigures(**{**plain, **given})


def test_the_terminal_line_has_speed_delay_and_notices():
    assert live_text(figures()) == "30 fps, latency 12 ms"
    assert live_text(figures(dropped=3, level_notice="slow", notice="gone")) == (
        "30 fps, latency 12 ms, 3 dropped, slow, gone"
    )
    assert live_text(figures(latency_ms=None)) == "waiting for the first frame"
    assert live_text(figures(latency_ms=None, notice="no camera")) == "no camera"


def test_sound_comes_back_after_a_camera_whose_sound_fails():
    camera, opened = SimpleNamespace(path="a", changes=0), []

    def sound():
        if camera.path == "b":
            raise InputError("the microphone is busy")
        opened.append(Mock())
        return opened[-1]

    kept = _Sound(camera, sound)
    assert kept.tap() is opened[0].tap() is kept.tap()
    camera.path = "b"
    with pytest.raises(InputError, match="busy"):
        kept.tap()
    camera.path = "a"
    assert opened[0].close.called and kept.tap() is opened[1].tap()
    camera.changes += 1  # the same file, from its beginning
    assert kept.tap() is opened[2].tap() and opened[1].close.called


def test_a_busy_microphone_is_tried_for_the_next_recording():
    opened = iter([None, sound := Mock()])
    kept = _Sound(SimpleNamespace(path=None, changes=0), lambda: next(opened))
    assert kept.tap() is None and kept.tap() is None  # outputs of one command: tried once
    assert kept.tap(again=True) is kept.tap() is kept.tap(again=True) is sound.tap()


class OpenTerminal(io.StringIO):
    def isatty(self):
        return True


class ClosedTerminal(io.StringIO):
    """A terminal whose window is closed: every write fails."""

    def isatty(self):
        return True

    def write(self, text):
        raise OSError(5, "Input/output error")

    def flush(self):
        self.write("")


def test_a_terminal_that_is_closed_ends_no_run(monkeypatch):
    monkeypatch.setattr(sys, "stderr", ClosedTerminal())
    with show_live(quiet=False) as shown:
        shown(figures())
        log("a line on the way")


@pytest.mark.parametrize("notice", ["rtmp://host/live/[/key]: refused", "[draft] camera"])
def test_a_terminal_shows_brackets_as_they_are(monkeypatch, notice):
    monkeypatch.setenv("COLUMNS", "200")
    terminal = OpenTerminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with show_live(quiet=False) as shown:
        shown(figures(notice=notice))
        deadline = time.monotonic() + 20
        while notice not in terminal.getvalue() and time.monotonic() < deadline:
            time.sleep(0.01)
    assert notice in terminal.getvalue()


def test_the_closing_line_counts_every_output_but_the_page():
    outputs = SinkFigures("out.mkv", 300, 0), SinkFigures("rtmp://host", 0, 0)
    assert "damaged" not in live_summary(figures(), 10.0)
    assert "0 dropped, 2 damaged" in live_summary(figures(damaged=2), 10.0)
    text = live_summary(figures(sinks=(SinkFigures("preview", 5, 90), *outputs)), 10.0)
    assert text == (
        "300 frames in 10.0 s, 30.0 fps, 0 dropped; out.mkv got 300 of them; "
        "rtmp://host got none of them"
    )


@pytest.mark.parametrize("words", [[], ["-o", "out.mkv"], ["-o", "out.mkv", "-q"]])
def test_a_stream_that_always_refuses_exits_with_4(folder, words):
    with socket.socket() as closed:  # bound, but not listening
        closed.bind(("127.0.0.1", 0))
        url = f"rtmp://127.0.0.1:{closed.getsockname()[1]}/live/s3cr3t"
        done = run(
            "--camera", "in.mkv", "--color", "#D00020", "--no-preview", "--stream", url, *words
        )
    assert done.exit_code == 4
    errors = [line for line in lines(done) if line.startswith("OutputError: rtmp://127.0.0.1: ")]
    assert len(errors) == 1 and "no frame was sent" in errors[0] and "s3cr3t" not in done.output
    assert ("rtmp://127.0.0.1 got none of them" in done.output) is ("-q" not in words)
    if words:
        assert decoded(folder / "out.mkv")  # the recording is complete all the same


def test_a_sink_that_fails_gives_its_exit_code(folder, monkeypatch):
    from makeup_video.pipeline import EncodeError
    from makeup_video.pipeline.live.sinks.recording import Recording

    def fail(self, picture):
        raise EncodeError("the encoder broke")

    monkeypatch.setattr(Recording, "__call__", fail)
    Look(lips=product((200, 0, 30), "matte")).save("a.json")
    done = run(
        "--camera", "in.mkv", "--look", "a.json", "-o", "out.mkv", "--port", "0", "--no-browser"
    )
    assert done.exit_code == EncodeError.exit_code
    assert "the encoder broke; the rest goes on" in done.output and "frames in" in done.output
