"""Progress of a run, on a terminal and elsewhere."""

import os
import pty
import re
import subprocess
import sys

import pytest
from media import make_clip


def test_the_progress_counts_only_what_the_trim_keeps(folder):
    from fractions import Fraction

    from makeup_video.pipeline import Settings, process_video

    src, totals = make_clip(folder / "long.mp4", frames=300), []
    settings = Settings(start_seconds=Fraction(2), end_seconds=Fraction(5))
    process_video(
        src, folder / "o.mp4", None, settings, lambda d, expected, r: totals.append(expected)
    )
    assert set(totals) == {90}


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
    assert "/1600" in text and " fps" in text and "x real time" in text
    assert text.rstrip().splitlines()[-1].startswith("out.mp4: 1600 frames in")


def test_without_a_terminal_a_plain_line_shows_now_and_then(monkeypatch, capsys):
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


def test_no_time_is_left_beyond_the_frames_expected():
    from fractions import Fraction

    from makeup_video.cli.progress import progress_text

    text = progress_text(120, 100, Fraction(30), 2.0)
    assert text == "120/100 frames, 60 fps, 2.0x real time"


@pytest.mark.parametrize("is_open", [False, True])
def test_a_terminal_shows_once_that_kernels_are_compiled(monkeypatch, capsys, is_open):
    from fractions import Fraction

    from makeup_video.cli import progress
    from makeup_video.kernels.program import Device
    from makeup_video.pipeline.render.opencl import open_device

    line = "compiling the kernels for this kind of video or picture"
    open_device()
    for has_terminal in (True, False):
        monkeypatch.setattr(progress, "_has_terminal", lambda has=has_terminal: has)
        with progress.show_progress(False) as on_progress:
            if is_open:
                on_progress(1, 10, Fraction(30))
            Device.on_compile()
            Device.on_compile()
        assert capsys.readouterr().err.count(line) == has_terminal
        Device.on_compile()  # in a later run of this process
    assert line not in capsys.readouterr().err
