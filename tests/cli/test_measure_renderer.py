"""The renderer's part of the bench measures what it says it measures. Nothing here is timed."""

import json

import numpy as np
import pytest
from makeup_video.cli import measure_renderer as measure
from makeup_video.cli.app import app
from makeup_video.pipeline import InputError
from media import decoded
from people import SAMPLES, grey
from people import film as write_film
from typer.testing import CliRunner

FRAMES = 12


@pytest.fixture(scope="module")
def face_clip(tmp_path_factory):
    folder = tmp_path_factory.mktemp("renderer")
    return measure.make_face_clip(SAMPLES / "in.mp4", folder / "face.mkv", 240, FRAMES)


@pytest.fixture(scope="module")
def faces(face_clip):
    return measure.find_in(face_clip)


def test_the_face_fills_half_the_height_in_the_middle(face_clip, faces):
    assert len(faces) == FRAMES and decoded(face_clip)[0].height == 240
    for (face,) in faces:
        ends = face.points_px[[10, 152], :2]
        assert np.linalg.norm(ends[0] - ends[1]) == pytest.approx(120, rel=0.1)
        assert np.abs(ends.mean(0) - np.array([decoded(face_clip)[0].width, 240]) / 2).max() < 24


def test_a_larger_frame_holds_the_same_face(face_clip, faces, tmp_path):
    larger, moved = measure.paste_into_larger(face_clip, tmp_path / "larger.mkv", faces)
    before, after = decoded(face_clip)[0], decoded(larger)[0]
    assert after.width >= 2.9 * before.width and after.height >= 2.9 * before.height
    shift = moved[0][0].points_px - faces[0][0].points_px
    x, y = np.round(shift[0, :2]).astype(int)
    luma = [np.asarray(picture.to_ndarray(), int) for picture in (before, after)]
    inner = luma[1][y : y + before.height, x : x + before.width]
    assert np.abs(inner - luma[0][: before.height, : before.width]).mean() < 2
    np.testing.assert_allclose(moved[0][0].lips.to_px[:, 2] - faces[0][0].lips.to_px[:, 2], [x, y])


def test_the_full_look_asks_for_everything():
    look = measure.full_look()
    for params in (look.lips, look.eyes):
        assert min(params.opacity, params.gloss, params.reflection, params.shimmer) > 0


def test_every_number_is_there(face_clip, faces):
    times = measure.paint_clip(face_clip, faces)
    assert set(times) == {"scene_ms", "composite_ms", "together_ms", "together_mean_ms"}
    assert min(times.values()) > 0


def test_the_floor_counts_pixels_bytes_and_operations(face_clip, faces):
    kernel = measure.kernel_beside_floor(face_clip, faces)
    assert 0 < kernel["painted_px"] < kernel["window_px"] < 240 * 427 / 10
    assert kernel["moved_bytes"] == 34 * kernel["window_px"]
    assert kernel["operations"] == measure.OPERATIONS_PER_PX * kernel["window_px"]
    assert min(kernel["kernel_ms"], kernel["copy_ms"], kernel["arithmetic_ms"]) > 0


def test_a_clip_without_a_face_is_refused(tmp_path):
    clip = write_film(tmp_path / "grey.mkv", [grey(64, 48)] * 3)
    with pytest.raises(InputError, match="no face"):
        measure.make_face_clip(clip, tmp_path / "out.mkv", 48, 3)


def test_the_command_prints_it_as_json_and_can_leave_it_out(tmp_path):
    args = ["bench", str(SAMPLES / "in.mp4"), "--sizes", "144p", "--seconds", "1"]
    args += ["--rounds", "1", "--json"]
    result = CliRunner().invoke(app, args)
    assert result.exit_code == 0, result.output
    painting = json.loads(result.stdout)["renderer"]
    assert painting["sizes"]["144p"]["composite_ms"] > 0
    assert painting["larger_frame_ratio"] > 0 and painting["start"]["first_seconds"] > 0
    without = CliRunner().invoke(app, [*args, "--no-renderer"])
    assert without.exit_code == 0 and "renderer" not in json.loads(without.stdout)
