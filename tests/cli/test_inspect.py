"""`makeup-video inspect`: a drawing, points as JSON, and one line when something is wrong."""

import json

import av
import numpy as np
import pytest
from makeup_video.cli.app import app
from media import decoded, make_clip, times_of
from people import SAMPLES, clip_points
from typer.testing import CliRunner


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*args):
    return CliRunner().invoke(app, ["inspect", *map(str, args)])


def test_a_video_comes_out_with_all_frames_times_and_sound_and_its_points(folder):
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


def test_a_film_without_a_face_says_so_and_is_no_error(folder):
    make_clip(folder / "in.mp4")
    done = run("in.mp4", "-o", "out.mp4")
    assert done.exit_code == 0
    assert "no face was found" in done.output


def test_quiet_says_nothing(folder):
    make_clip(folder / "in.mp4")
    assert run("in.mp4", "-o", "out.mp4", "-q").output == ""


@pytest.mark.parametrize(
    ("args", "code", "words"),
    [
        (["none.mp4", "-o", "out.mp4"], 3, "does not exist"),
        (["in.mp4", "-o", "in.mp4"], 2, "in.mp4"),
        (["in.mp4", "-o", "out.mp4", "--json", "in.mp4"], 2, "own files"),
        (["in.mp4", "-o", "out.mp4", "--json", "no/where.json"], 4, "no such folder"),
        (["in.mp4", "-o", "out.mp4", "--start", "x"], 2, "--start"),
    ],
)
def test_every_mistake_is_one_line_with_its_exit_code(folder, args, code, words):
    make_clip(folder / "in.mp4")
    done = run(*args)
    assert done.exit_code == code
    assert words in done.output
    assert len(done.output.strip().splitlines()) == 1
    assert not (folder / "out.mp4").exists()
