"""The benchmark of the renderer measures what it reports. Nothing here is timed."""

import pytest
from makeup_video.benchmark import renderer, videos
from makeup_video.pipeline.look.kinds import KINDS
from people import SAMPLES

FRAMES = 12


@pytest.fixture(scope="module")
def face_clip(tmp_path_factory):
    target = tmp_path_factory.mktemp("renderer") / "face.mkv"
    return videos.make_video(SAMPLES / "in.mp4", target, 240, FRAMES).path


@pytest.fixture(scope="module")
def faces(face_clip):
    return renderer.find_in(face_clip)


def test_faces_are_found_in_every_frame(faces):
    assert [len(found) for found in faces] == [1] * FRAMES


def test_the_full_look_uses_every_effect_on_lips_and_eyes():
    look = renderer.full_look()
    assert look.kinds == ("lipstick", "eyeshadow") and look.zone == "full"
    for layer in look.layers:
        params = layer.product
        assert min(params.opacity, params.gloss, params.reflection, params.shimmer) > 0


def test_the_whole_look_has_every_kind_and_three_shadows():
    look = renderer.whole_look()
    assert set(look.kinds) == set(KINDS) and len(look.of("eyeshadow")) == 3


def test_the_whole_look_is_measured_beside_the_full_one(face_clip):
    assert renderer.paint_costs(face_clip, 1)["whole_look"] > 0


def test_every_number_is_there(face_clip, faces):
    times = renderer.paint_clip(face_clip, faces)
    assert set(times) == {"scene_ms", "composite_ms", "together_ms", "together_mean_ms"}
    assert min(times.values()) > 0


def test_kernel_launches_are_counted_whoever_starts_them(face_clip, faces):
    kernel = renderer.kernel_alone(face_clip, faces, renderer.full_look())
    assert kernel["launches"] >= 1 and kernel["kernel_ms"] > 0
    assert 0 < kernel["painted_px"] <= kernel["work_items"] < 240 * 427 / 5
