"""Which faces are painted, when, and how strongly."""

from dataclasses import replace

import numpy as np
import pytest
from makeup import (
    close_up,
    close_up_scene,
    copied,
    inside,
    paint_planes,
    product,
    scene_of,
    true_face,
    white_light,
)
from makeup_video.pipeline.errors import UsageError
from makeup_video.pipeline.faces.topology import LIPS_OUTER
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.render.composite import Composite
from people import frame_of

LIPS = Look(lips=product())
EYES = Look(eyes=product(red=0, green=90, blue=40))
BOTH = Look(lips=LIPS.lips, eyes=EYES.eyes)


def change(scene, look):
    """Return (H, W): the change of luma in codes."""
    return np.abs(paint_planes(scene, look)[0].astype(int) - scene.frame.planes[0])


def two_faces():
    """Return a scene of two faces side by side: number 7 is the larger, number 3 the smaller."""
    rgb8, points = close_up()
    small = rgb8[::2, ::2]
    ground = np.full((rgb8.shape[0], 310, 3), 90, np.uint8)
    ground[:, :200] = rgb8
    ground[: small.shape[0], 205:305] = small
    faces = true_face(points, 7), true_face(points / 2 + (205, 0), 3)
    return scene_of(frame_of(ground, pix_fmt="yuv444p"), faces, white_light())


def painted_by(composite, scene):
    rgb8 = scene.frame.picture.to_ndarray(format="yuv444p")
    frame = scene.frame
    fresh = type(frame.picture).from_ndarray(rgb8, format="yuv444p")
    target = Frame(fresh, frame.pts, frame.time_base, frame.tags)
    return composite(replace(scene, frame=target)).planes[0].astype(int)


@pytest.mark.parametrize("chosen", ["all", "largest", "7", "3", "99"])
def test_the_chosen_faces_are_painted_and_no_others(chosen):
    scene = two_faces()
    composite = Composite(LIPS, faces=chosen)
    changed = painted_by(composite, scene) != scene.frame.planes[0]
    assert changed[:, :200].any() == (chosen in ("all", "largest", "7"))
    assert changed[:, 200:].any() == (chosen in ("all", "3"))
    assert composite.painted_frames == (chosen != "99")


def test_the_largest_face_changes_only_for_a_much_larger_one():
    rgb8, points = close_up()
    frame = frame_of(np.concatenate([rgb8, rgb8], 1), pix_fmt="yuv444p")
    middle = points.mean(0)
    composite = Composite(LIPS, faces="largest")
    painted = []
    for size in (0.97, 1.03, 0.97, 1.06, 1.3, 0.97, None):
        faces = [true_face(points, 0)]
        if size is not None:
            faces.append(true_face(middle + (points - middle) * size + (200, 0), 1))
        faces.sort(key=lambda face: -face.area_px2)
        changed = painted_by(composite, scene_of(frame, tuple(faces))) != frame.planes[0]
        assert changed[:, :200].any() != changed[:, 200:].any()
        painted.append(int(changed[:, 200:].any()))
    assert painted == [0, 0, 0, 0, 1, 1, 0]


def test_only_frames_with_something_to_paint_are_counted():
    composite = Composite(LIPS)
    rgb8, points = close_up()
    for faces in ((), (true_face(points, mouth_visible=0.1),), (true_face(points),)):
        composite(scene_of(frame_of(rgb8), faces))
    assert composite.painted_frames == 1


def test_lids_beyond_the_border_are_not_painted():
    rgb8, points = close_up()
    composite = Composite(Look(eyes=product()))
    away = true_face(points - (0, points[[145, 374], 1].max() + 12))  # the lower lids
    assert composite(scene_of(frame_of(rgb8), (away,))) and composite.painted_areas == set()
    assert composite.painted_frames == 0


def test_the_parts_of_faces_that_were_painted_are_remembered():
    rgb8, points = close_up()
    composite = Composite(Look(lips=product(), eyes=product()))
    hidden, seen = true_face(points, mouth_visible=0.1), true_face(points)
    for face, parts in ((hidden, {"eyes"}), (seen, {"eyes", "mouth"}), (hidden, {"eyes", "mouth"})):
        composite(scene_of(frame_of(rgb8), (face,)))
        assert composite.painted_areas == parts


def test_a_frame_that_is_not_painted_is_not_copied():
    rgb8, points = close_up()
    for look, faces in ((LIPS, ()), (Look(), (true_face(points),))):
        frame = frame_of(rgb8)
        address = frame.planes[0].ctypes.data
        assert Composite(look)(scene_of(frame, faces)) is frame
        assert frame.planes[0].ctypes.data == address


def test_a_frame_keeps_its_time_and_its_tags():
    rgb8, points = close_up()
    frame = frame_of(rgb8, 31)
    painted = Composite(BOTH)(scene_of(frame, (true_face(points),)))
    assert painted.pts == 31 and painted.time_base == frame.time_base
    assert painted.tags == frame.tags


def test_a_grey_frame_holds_no_colour_and_stays():
    rgb8, points = close_up()
    frame = frame_of(rgb8, pix_fmt="gray")
    before = copied(frame)
    Composite(BOTH)(scene_of(frame, (true_face(points),)))
    np.testing.assert_array_equal(frame.planes[0], before[0])


def test_a_new_look_takes_effect_at_the_next_frame():
    scene = close_up_scene()
    composite = Composite(Look())
    bare = painted_by(composite, scene)
    composite.set_look(LIPS)
    red = painted_by(composite, scene)
    composite.set_look(replace(LIPS, strength=0.0))
    at_no_strength = painted_by(composite, scene)
    np.testing.assert_array_equal(bare, scene.frame.planes[0])
    np.testing.assert_array_equal(at_no_strength, bare)
    np.testing.assert_array_equal(np.abs(red - bare), change(scene, LIPS))
    assert (red != bare).any()


@pytest.mark.parametrize("of", ["look", "layer"])
@pytest.mark.parametrize("kind", KINDS)
def test_strength_of_a_look_and_of_a_layer_scale_the_painting(of, kind):
    scene, worn = close_up_scene(), product(red=0, green=90, blue=40)
    sums = []
    for share in (0, 0.25, 0.5, 0.75, 1):
        layer = Layer(kind, worn, strength=share if of == "layer" else 1)
        sums.append(change(scene, Look([layer], share if of == "look" else 1)).sum())
    assert sums[0] == 0 and (np.diff(sums) > 0).all()


def test_the_strength_of_a_layer_leaves_other_layers_alone():
    scene = close_up_scene()
    weak = Look(lips=LIPS.lips, eyes=EYES.eyes, intensity=0.2)
    both, weaker = (change(scene, look) for look in (BOTH, weak))
    eyes = change(scene, EYES) > 0
    assert weaker[eyes].sum() < both[eyes].sum()
    np.testing.assert_array_equal(weaker[~eyes], both[~eyes])


def test_a_mouth_is_painted_as_far_as_it_is_visible():
    rgb8, points = close_up()
    sums = []
    for visible in (0.1, 0.6, 1.0):
        faces = (true_face(points, mouth_visible=visible),)
        scene = scene_of(frame_of(rgb8, pix_fmt="yuv444p"), faces, white_light())
        sums.append(change(scene, LIPS).sum())
        assert change(scene, BOTH).sum() > sums[-1]  # the eyes are painted all the same
    assert sums[0] == 0 < sums[1] < sums[2]


def test_lips_and_eyes_are_painted_apart():
    scene = close_up_scene()
    lips, eyes, both = (change(scene, look) for look in (LIPS, EYES, BOTH))
    np.testing.assert_array_equal(lips + eyes, both)
    assert not (lips * eyes).any()
    _, points = close_up()
    on_lips = inside(points[LIPS_OUTER], lips.shape)
    assert (lips[on_lips] > 0).mean() > 0.7


@pytest.mark.parametrize("pix_fmt", ["yuv420p", "nv12"])
def test_faces_that_overlap_are_painted_one_after_the_other(pix_fmt):
    rgb8, points = close_up()
    frame = frame_of(rgb8, pix_fmt=pix_fmt)
    beside = points + np.array([6, 3])
    scene = scene_of(frame, (true_face(points, 0), true_face(beside, 1)), white_light())
    both = paint_planes(scene, BOTH)
    for face in scene.faces:
        planes = paint_planes(replace(scene, faces=(face,)), BOTH)
        for new, old in zip(scene.frame.writable_planes(), planes, strict=True):
            new[:] = old
    for got, want in zip(both, scene.frame.planes, strict=True):
        np.testing.assert_array_equal(got, want)


@pytest.mark.parametrize("offset", [(-90, 0), (110, 0), (0, -130), (60, 60), (9000, 0), (0, -9000)])
def test_faces_partly_or_wholly_outside_are_painted_safely(offset):
    rgb8, points = close_up()
    scene = scene_of(frame_of(rgb8), (true_face(points + offset),), white_light())
    after = paint_planes(scene, BOTH)
    assert [plane.shape for plane in after] == [plane.shape for plane in scene.frame.planes]


def test_a_missing_device_is_a_usage_error():
    with pytest.raises(UsageError, match="no such device"):
        Composite(LIPS, device="no such device")
