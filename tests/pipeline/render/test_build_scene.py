"""Building scenes: the lips and lids of every face, their light, and the light over time."""

from concurrent.futures import ThreadPoolExecutor

import heads
import numpy as np
import pytest
from makeup import close_up, lit_of, scene_of, true_face
from makeup_video.kernels.colour import decode
from makeup_video.pipeline.errors import UsageError
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.render.build_scene import BuildScene
from people import TICK, frame_of

RGB8, POINTS = close_up()


def item(pts=0, gain=1.0, track_id=0, cut=False):
    rgb8 = np.clip(RGB8 * gain, 0, 255).astype(np.uint8)
    return FrameFaces(frame_of(rgb8, pts), (true_face(POINTS, track_id),), cut)


def means(build, *items):
    """Return the mean light of the lips after each frame."""
    return [build(item).faces[0].regions["lips"][0].mean for item in items]


def test_a_frame_without_faces_is_a_scene_without_faces():
    scene = BuildScene()(FrameFaces(frame_of(RGB8)))
    assert scene.faces == () and scene.coding.matrix == 1


def test_a_face_has_lips_and_two_lids_each_with_its_light():
    scene = scene_of(frame_of(RGB8), (true_face(POINTS),))
    (face,) = scene.faces
    assert len(face.regions["eyes"]) == 2
    for lit in lit_of(face):
        assert lit.shading.shape == lit.surface.normals.shape[1:]
        assert lit.shading.dtype == np.float32
        assert 0.02 < lit.mean < 0.7 and lit.shading.min() > 0
    codes = np.stack(frame_of(RGB8, pix_fmt="yuv444p").planes, axis=-1).astype(float)
    skin = decode(codes, scene.coding) @ (0.2126, 0.7152, 0.0722)
    lips = skin[round(POINTS[17, 1]) - 3, round(POINTS[17, 0])]  # above the lower border
    assert face.regions["lips"][0].mean == pytest.approx(lips, rel=0.6)


def test_a_hidden_mouth_is_missing_and_the_eyes_are_not():
    (face,) = scene_of(frame_of(RGB8), (true_face(POINTS, mouth_visible=0.1),)).faces
    assert not face.regions["lips"] and len(face.regions["eyes"]) == 2


def test_faces_keep_their_order_and_their_lights():
    faces = true_face(POINTS, 4), true_face(POINTS * 0.6, 2)
    scene = scene_of(frame_of(RGB8), faces)
    assert [face.face.track_id for face in scene.faces] == [4, 2]


def test_a_face_outside_the_frame_has_a_scene_too():
    scene = scene_of(frame_of(RGB8), (true_face(POINTS + 5000), true_face(POINTS - 5000, 1)))
    assert len(scene.faces) == 2
    for face in scene.faces:
        assert np.isfinite(face.regions["lips"][0].shading).all() and np.isfinite(
            face.light.strength
        )


def test_a_face_from_the_side_has_the_lid_that_is_seen():
    points = POINTS.copy()
    middle = points[:, 0].mean()
    points[:, 0] = np.where(
        points[:, 0] < middle, middle + 0.02 * (points[:, 0] - middle), points[:, 0]
    )
    (face,) = scene_of(frame_of(RGB8), (heads.face(points),)).faces
    assert len(face.regions["eyes"]) <= 2 and face.regions["lips"]


def test_light_settles_slowly_and_by_time_not_by_frames():
    build = BuildScene()
    first, at_once, later, settled = means(
        build, item(0), item(1, 0.6), item(15, 0.6), item(40, 0.6)
    )
    (dim,) = means(BuildScene(), item(0, 0.6))
    assert abs(at_once - first) < 0.15 * (first - dim)
    assert dim < settled < later < at_once
    rare = means(BuildScene(), item(0), item(15, 0.6))[-1]
    often = means(BuildScene(), item(0), *(item(pts, 0.6) for pts in range(1, 16)))[-1]
    assert rare == pytest.approx(often, rel=0.02)


def test_a_steady_light_stays_as_it_is():
    values = means(BuildScene(), *(item(pts) for pts in range(4)))
    assert values == pytest.approx([values[0]] * 4)


@pytest.mark.parametrize(
    "second", [item(1, 0.6, cut=True), item(1, 0.6, track_id=5), item(60, 0.6), item(-9, 0.6)],
    ids=["a cut", "another face", "after a while", "a clock that jumps back"],
)  # fmt: skip
def test_light_is_read_anew_after_a_cut_or_a_pause(second):
    build = BuildScene()
    assert means(build, item(0), second)[-1] == pytest.approx(
        means(BuildScene(), item(0, 0.6))[0], rel=1e-6
    )


def test_lights_of_faces_that_are_gone_are_forgotten():
    build = BuildScene()
    for number in range(50):
        build(item(number, track_id=number))
    assert len(build._means) <= 3 * (1 / TICK + 1)


def test_a_missing_device_is_refused():
    with pytest.raises(UsageError, match="no such device"):
        BuildScene("no such device")


def test_threads_that_build_scenes_at_once_do_not_mix_them_up():
    frame, (points, eyes_closed) = frame_of(RGB8), (close_up(number)[1] for number in (0, 75))
    faces = [true_face(points), true_face(eyes_closed)]
    alone = [BuildScene()(FrameFaces(frame, (face,))).faces[0] for face in faces]

    def build_scenes(number):
        build = BuildScene()
        return [build(FrameFaces(frame, (faces[number],))).faces[0] for _ in range(50)]

    with ThreadPoolExecutor(2) as pool:
        for scenes, want in zip(pool.map(build_scenes, (0, 1)), alone, strict=True):
            for scene in scenes:
                (lips, *lids), (wanted, *wanted_lids) = lit_of(scene), lit_of(want)
                np.testing.assert_array_equal(lips.shading, wanted.shading)
                np.testing.assert_array_equal(lids[1].surface.up, wanted_lids[1].surface.up)
