"""`--split` as it is typed: its report, Ctrl-C and a killed process, and what they leave."""

import contextlib
import json
import os
import shutil
import signal
import time
from pathlib import Path

import pytest
from command_line import command, run
from media import decoded, make_clip
from split_videos import GROUP, differences

ARGUMENTS = ("--look", "none", "-o", "out.mp4", "--split", "0.017")


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    path = tmp_path_factory.mktemp("video") / "in.mp4"
    return make_clip(path, frames=600, size_wh=(640, 360), options=GROUP)


@pytest.fixture
def src(video, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copy(video, tmp_path))


def children_of(process):
    """Children of all threads, because a thread of its own starts each worker."""
    found = []
    for task in Path(f"/proc/{process.pid}/task").glob("*/children"):
        with contextlib.suppress(OSError):  # the thread has ended
            found += map(int, task.read_text().split())
    return found


def workers_of(process):
    return [
        number
        for number in children_of(process)
        if b"spawn_main" in Path(f"/proc/{number}/cmdline").read_bytes()
    ]


def begun(folder, process):
    """Wait until a segment is being written; returns the processes that write."""
    deadline = time.monotonic() + 60
    while not list(folder.glob("out.part.mp4.segments/*")) and time.monotonic() < deadline:
        time.sleep(0.01)
    return workers_of(process)


def test_a_video_is_painted_in_segments(tmp_path, src):
    done = run(src, *ARGUMENTS, "--jobs", "2", "--report", "r.json")
    assert done.exit_code == 0, done.output
    report = json.loads((tmp_path / "r.json").read_text())
    assert (report["segments"], report["frames_out"]) == (17, 600)
    assert len(decoded(tmp_path / "out.mp4")) == 600


@pytest.mark.parametrize("name", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_leaves_nothing(tmp_path, src, name):
    process = command(src, *ARGUMENTS)
    workers = begun(tmp_path, process)
    process.send_signal(name)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130 and stderr.splitlines()[-1] == "stopped"
    assert [path.name for path in tmp_path.iterdir()] == ["in.mp4"]
    assert workers and not any(Path(f"/proc/{number}").exists() for number in workers)


def test_a_segment_whose_process_is_killed_is_painted_again(tmp_path, src):
    process = command(src, *ARGUMENTS, "-q")
    worker, *_ = begun(tmp_path, process)
    os.kill(worker, signal.SIGKILL)
    _, stderr = process.communicate(timeout=60)
    assert (process.returncode, stderr) == (0, "")
    assert len(decoded(tmp_path / "out.mp4")) == 600
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.mp4", "out.mp4"]


def test_a_part_of_a_video_is_painted_in_segments(tmp_path, src):
    part = ("--start", "3.21", "--end", "9.5")
    assert run(src, *ARGUMENTS, *part, "--report", "r.json").exit_code == 0
    assert run(src, "--look", "none", "-o", "whole.mp4", *part).exit_code == 0
    assert json.loads((tmp_path / "r.json").read_text())["segments"] > 1
    assert differences(tmp_path / "whole.mp4", tmp_path / "out.mp4") == []


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--split", "0"], "--split must be more than 0, got 0"),
        (["--split", "nan"], "--split must be a number of minutes, got nan"),
        (["--jobs", "2"], "--jobs needs --split"),
        (["--split", "1", "--start", "99"], "--start 99 s is beyond the end"),
        (["--ray", "auto"], "--ray paints the segments of --split MINUTES: add it"),
        (["--look", "glam", "-o", "{look}.mp4", "--ship"], "--ship is for a cluster: add"),
        (["--split", "1", "--ship"], "--ship is for a cluster: add --ray ADDRESS"),
        (
            ["--look", "glam", "-o", "{look}.mp4", "--split", "1"],
            "leave out --split, or paint each",
        ),
    ],
)
def test_options_that_do_not_fit_are_one_line(src, words, text):
    done = run(src, "--look", "none", "-o", "out.mp4", *words)
    assert done.exit_code == 2 and text in done.output
