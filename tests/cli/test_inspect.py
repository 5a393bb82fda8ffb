"""`makeup-video inspect`: a drawing, points as JSON, and errors of one line."""

import json
import os
import signal
import subprocess
import sys
import time

import av
import cv2
import numpy as np
import pytest
from makeup_video.cli.app import app
from makeup_video.pipeline import Settings, UsageError, inspect_video
from media import damage, decoded, make_clip, times_of
from people import SAMPLES, clip_points, face_of, grey, put
from typer.testing import CliRunner


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*args):
    return CliRunner().invoke(app, ["inspect", *map(str, args)])


def test_a_video_keeps_frames_times_and_sound(folder):
    done = run(SAMPLES / "in.mp4", "-o", "out.mp4", "--json", "points.json", "--end", "1")
    assert done.exit_code == 0
    assert "faces: 1, in 30 frames" in done.output
    assert len(decoded(folder / "out.mp4")) == 30
    assert times_of(folder / "out.mp4") == times_of(SAMPLES / "in.mp4")[:30]
    with av.open(str(folder / "out.mp4")) as container:
        assert container.streams.audio
    frames = json.loads((folder / "points.json").read_text())["frames"]
    assert [len(frame["faces"]) for frame in frames] == [1] * 30
    assert {frame["faces"][0]["id"] for frame in frames} == {0}
    points = np.array([frame["faces"][0]["points_px"] for frame in frames])[..., :2]
    true = clip_points()[:30] * 2 + 0.5
    off = np.linalg.norm(points - true, axis=2).mean()
    assert off < 0.045 * np.linalg.norm(true[0, 33] - true[0, 263])


@pytest.mark.parametrize("end", [".jpg", ".png"])
def test_a_picture_is_drawn_on(folder, end):
    done = run(SAMPLES / "portrait.jpg", "-o", f"out{end}", "--json", "points.json")
    assert done.exit_code == 0
    assert "faces: 1, in 1 frame" in done.output
    assert len(json.loads((folder / "points.json").read_text())["frames"]) == 1
    assert (folder / f"out{end}").stat().st_size > 10_000


def test_a_video_without_a_face_is_reported_but_no_error(folder):
    make_clip(folder / "in.mp4")
    done = run("in.mp4", "-o", "out.mp4")
    assert done.exit_code == 0
    assert "no face was found" in done.output


def test_quiet_prints_nothing(folder):
    make_clip(folder / "in.mp4")
    assert run("in.mp4", "-o", "out.mp4", "-q").output == ""


@pytest.mark.parametrize(
    ("args", "code", "words"),
    [
        (["none.mp4", "-o", "out.mp4"], 3, "does not exist"),
        ([".", "-o", "out.mp4"], 3, "is a folder: give one video or photo file\n"),
        (["in.mp4", "-o", "in.mp4"], 2, "in.mp4"),
        (["in.mp4", "-o", "out.mp4", "--json", "in.mp4"], 2, "own files"),
        (["in.mp4", "-o", "out.mp4", "--json", "out.mp4"], 2, "own files"),
        (["in.mp4", "-o", "out.mp4", "--json", "out.part.mp4", "-y"], 2, "own files"),
        (["in.mp4", "-o", "x.part.mp4", "--json", "x.mp4", "-y"], 2, "own files"),
        (["in.mp4", "-o", "out.mp4", "--json", "twin.mp4", "-y"], 2, "own files"),
        (["in.mp4", "-o", "out.mp4", "--json", "link.json", "-y"], 2, "own files"),
        (["in.mp4", "-o", "out.mp4", "--json", "old.json"], 2, "add -y"),
        (["in.mp4", "-o", "out.mp4", "--json", "no/where.json"], 4, "does not exist"),
        (["in.mp4", "-o", "out.mp4", "--json", "-"], 2, "stdout, got -: give a file, or ./- for"),
        (["in.mp4", "-o", "out.mp4", "--json", "."], 4, "is a folder"),
        (["in.mp4", "-o", "out.mp4", "--json", "/"], 4, "is a folder"),
        (["in.mp4", "-o", "", "--json", "p.json"], 2, "must end in"),
        (["photo.jpg", "-o", "out.jpg", "--start", "1"], 2, "leave out --start"),
        (["in.mp4", "-o", "out.mp4", "--start", "x"], 2, "--start"),
    ],
)
def test_every_mistake_is_one_line_with_its_exit_code(folder, args, code, words):
    make_clip(folder / "in.mp4")
    os.link("in.mp4", "twin.mp4")
    os.symlink("in.mp4", "link.json")
    os.symlink(SAMPLES / "portrait.jpg", "photo.jpg")
    (folder / "old.json").write_text("precious")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    done = run(*args)
    assert done.exit_code == code
    assert words in done.output
    assert len(done.output.strip().splitlines()) == 1
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("name", ["in.mp4", "out.mp4", "./out.part.mp4"])
def test_python_too_never_writes_points_over_another_file(folder, name):
    data = make_clip(folder / "in.mp4").read_bytes()
    with pytest.raises(UsageError, match="own files"):
        inspect_video("in.mp4", "out.mp4", name, Settings(overwrite=True))
    assert [path.name for path in folder.iterdir()] == ["in.mp4"]
    assert (folder / "in.mp4").read_bytes() == data


def test_yes_overwrites_both_and_leaves_no_part(folder):
    make_clip(folder / "in.mp4")
    for name in ("out.mp4", "points.json", "out.part.mp4", "points.part.json"):
        (folder / name).write_text("old")
    assert run("in.mp4", "-o", "out.mp4", "--json", "points.json", "-y").exit_code == 0
    assert len(json.loads((folder / "points.json").read_text())["frames"]) == 12
    assert sorted(path.name for path in folder.iterdir()) == ["in.mp4", "out.mp4", "points.json"]


def test_an_error_leaves_no_points_file(folder):
    (folder / "in.mp4").write_bytes(b"no video")
    assert run("in.mp4", "-o", "out.mp4", "--json", "points.json").exit_code == 3
    assert [path.name for path in folder.iterdir()] == ["in.mp4"]


def test_damaged_input_exits_with_5_and_warns_when_quiet(folder):
    damage(make_clip(folder / "in.mp4", frames=60, size_wh=(320, 240)))
    for quiet in ([], ["-q"]):
        done = run("in.mp4", "-o", "out.mp4", "--json", "points.json", "-y", *quiet)
        assert done.exit_code == 5, done.output
        assert "the input is damaged: " in done.output
    frames = len(decoded(folder / "out.mp4"))
    assert len(json.loads((folder / "points.json").read_text())["frames"]) == frames > 30


def test_ctrl_c_leaves_a_playable_part_and_the_points_so_far(folder):
    make_clip(folder / "in.mp4", frames=600, size_wh=(640, 360))
    words = [sys.executable, "-m", "makeup_video.cli", "inspect", "in.mp4", "-o", "out.mp4"]
    process = subprocess.Popen(
        [*words, "--json", "points.json"],
        stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    part = folder / "out.part.mp4"
    deadline = time.monotonic() + 30
    while not (part.exists() and part.stat().st_size > 20000) and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=30)
    assert process.returncode == 130
    assert stderr.splitlines()[-1] == "stopped; out.part.mp4 holds what was done"
    assert 0 < len(decoded(part)) < 600
    frames = json.loads((folder / "points.part.json").read_text())["frames"]
    assert len(frames) >= len(decoded(part))
    assert not {"out.mp4", "points.json"} & {path.name for path in folder.iterdir()}


def test_faces_that_are_too_small_are_counted_in_a_picture(folder):
    picture = put(put(grey(640, 360), face_of(28), 60, 100), face_of(100), 300, 80)
    cv2.imwrite("in.png", picture[..., ::-1])
    done = run("in.png", "-o", "out.png")
    assert "faces under 40 px wide were not painted (1 seen)" in done.output
    assert "faces: 1, in 1 frame" in done.output
    assert inspect_video("in.png", "again.png").tiny_faces == 1
