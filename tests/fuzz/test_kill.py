"""`kill -9` at any moment leaves a whole output or none, and nothing that blocks the next run.

These tests take minutes: run them with `pytest -m slow`.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from random import Random

import av
import cv2
import numpy as np
import pytest
from media import add_video, decoded, tone
from people import portrait

pytestmark = pytest.mark.slow

FRAMES = 40
KILLS = 100
OLD = b"an older file\n" * 99
FILES = {"in.mp4", "out.mp4", "out.part.mp4", "report.json", "report.part.json"}


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    """The bytes of a video of a face that moves back and forth, with audio."""
    path = tmp_path_factory.mktemp("clip") / "in.mp4"
    rgb8 = cv2.resize(portrait(), (256, 304), interpolation=cv2.INTER_AREA)
    with av.open(str(path), "w") as out:
        video = add_video(out, size_wh=(256, 304))
        sound = out.add_stream("aac", rate=48000, layout="stereo")
        for index in range(FRAMES):
            moved = np.roll(rgb8, round(6 * np.sin(index / 4)), axis=1)
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(moved), format="rgb24")
            frame.pts = index
            out.mux(video.encode(frame.reformat(format="yuv420p")))
        out.mux(video.encode(None))
        tone(out, sound, FRAMES / 30)
    return path.read_bytes()


@pytest.fixture(scope="module")
def seconds(clip, tmp_path_factory):
    """(seconds until the output grows, total seconds) of a run that is not killed; the kernels are
    already compiled."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "in.mp4").write_bytes(clip)
    assert start(folder, "--report", "report.json").wait() == 0
    began = time.monotonic()
    run = start(folder, "-y")
    until_output = wait_for_output(run, folder) - began
    assert run.wait() == 0 and is_whole(folder / "out.mp4")
    return until_output, time.monotonic() - began


def start(folder, *options):
    command = [sys.executable, "-m", "makeup_video.cli", "in.mp4", "--color", "B4002E"]
    command += ["-o", "out.mp4", "-q", *options]
    return subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True)


def wait_for_output(run, folder):
    """Wait until the output grows, under any name, or the run ends."""
    before = sizes(folder)
    while run.poll() is None and sizes(folder) == before:
        time.sleep(0.001)
    return time.monotonic()


def sizes(folder):
    return {path.name: os.path.getsize(path) for path in folder.glob("out*")}


def is_whole(path):
    return len(decoded(path)) == FRAMES


@pytest.mark.parametrize("number", range(KILLS))
def test_a_killed_run_leaves_a_whole_output_or_none(tmp_path, clip, seconds, number):
    r = Random(f"kill/{number}")
    options = (["-y"] if number % 2 else []) + (["--report", "report.json"] if number % 3 else [])
    (tmp_path / "in.mp4").write_bytes(clip)
    had = {name for name in ("out.mp4", "report.json") if number % 2 and r.random() < 0.8}
    for name in had:
        (tmp_path / name).write_bytes(OLD)
    run = start(tmp_path, *options)
    until_output, in_all = seconds
    if number % 4 < 2:  # at any moment, or while the output grows
        time.sleep(r.uniform(0, 1.1 * in_all))
    else:
        wait_for_output(run, tmp_path)
        time.sleep(r.uniform(0, 1.1 * (in_all - until_output)))
    run.send_signal(signal.SIGKILL)
    run.wait()
    assert_nothing_half_done(tmp_path, clip, had)
    again = start(tmp_path, *options, "-y")
    assert (again.wait(), again.stderr.read()) == (0, "")
    assert is_whole(tmp_path / "out.mp4")
    assert set(os.listdir(tmp_path)) <= {"in.mp4", "out.mp4", "report.json"}


def assert_nothing_half_done(folder: Path, clip: bytes, had: set[str]) -> None:
    assert (folder / "in.mp4").read_bytes() == clip
    assert set(os.listdir(folder)) <= FILES
    video, report = folder / "out.mp4", folder / "report.json"
    if video.exists() and video.read_bytes() != OLD:
        assert is_whole(video)
    if report.exists() and report.read_bytes() != OLD:
        assert json.loads(report.read_text())["frames_out"] == FRAMES
    assert had <= set(os.listdir(folder))
