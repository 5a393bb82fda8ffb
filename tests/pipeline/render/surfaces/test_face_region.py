"""The surface of a resting face is used again, and whatever changes it makes a new one."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lit_faces import face_at, points
from makeup import device, white_light
from makeup_video.kernels.face import STEP
from makeup_video.pipeline.faces.topology import LIPS_OUTER
from makeup_video.pipeline.frames.frame import coding_of
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.scene import FaceScene, FrameScene
from makeup_video.pipeline.render.surfaces.face_region import FACE
from makeup_video.pipeline.render.surfaces.region import Reader
from people import frame_of, portrait

IOD_PX = float(np.linalg.norm(points()[33] - points()[263]))
BLUSH = Look([Layer("blush", product((214, 92, 104), "matte", "blush"))])
JITTER = 0.0004  # of the eyes' distance: that of smoothed points of a still face


def scene_at(pts, points_px=None, rgb8=None, track_id=0, cut=False):
    """The portrait as frame `pts` of a video of 30 frames a second."""
    frame = frame_of(portrait() if rgb8 is None else rgb8, pts)
    face = face_at(points() if points_px is None else points_px, track_id)
    return FrameScene(frame, coding_of(frame), (FaceScene(face, white_light(), {}),), cut)


def read(scenes):
    """The light of each scene, read one after another; light used again is the same array."""
    reader = Reader(device())
    return [FACE.lit(scene, scene.faces[0], reader)[0] for scene in scenes]


def is_used_again(first, second):
    one, other = read([first, second])
    return one.shading is other.shading


def jittered(seed):
    noise = np.zeros((478, 3))
    noise[:, :2] = np.random.default_rng(seed).normal(0, JITTER * IOD_PX, (478, 2))
    return points() + noise


def shifted(step):
    """The portrait and its points, moved to the right by whole pixels."""
    return points() + np.array((step, 0, 0)), np.roll(portrait(), step, axis=1)


def painted(composite, scene):
    return [plane.astype(int) for plane in composite(scene).planes]


def largest_change(one, other):
    return max(int(np.abs(a - b).max()) for a, b in zip(one, other, strict=True))


def test_a_resting_face_is_made_anew_every_third_frame():
    lits = read(scene_at(pts, jittered(pts)) for pts in range(9))
    made = [0] + [at for at in range(1, 9) if lits[at].shading is not lits[at - 1].shading]
    assert made == [0, 3, 6]


@pytest.mark.parametrize("step", [0, 2, 10])
def test_a_surface_used_again_paints_as_a_fresh_one(step):
    kept = Composite(BLUSH)
    for pts in range(3):
        at, rgb8 = shifted(pts * step)
        at += jittered(pts) - points()
        again = painted(kept, scene_at(pts, at, rgb8))
        fresh = painted(Composite(BLUSH), scene_at(pts, at, rgb8))
        bare = [plane.astype(int) for plane in frame_of(rgb8).planes]
        assert largest_change(fresh, bare) > 8
        # a veil is rounded at a quarter of the size and once more where it is added
        assert largest_change(again, fresh) <= 2
        assert np.mean(np.abs(again[0] - fresh[0]) > 1) < 1e-3


@settings(max_examples=20, deadline=None)
@given(st.floats(1.2, 100), st.floats(-np.pi, np.pi), st.sampled_from([4, *LIPS_OUTER.tolist()]))
def test_a_face_that_changes_its_shape_is_read_anew(times, angle, point):
    moved = points().copy()
    moved[point, :2] += times * 0.4 * STEP * IOD_PX * np.array([np.cos(angle), np.sin(angle)]) * 2
    assert not is_used_again(scene_at(0), scene_at(1, moved))


@pytest.mark.parametrize("gain", [0.5, 0.9, 1.1])
@pytest.mark.parametrize("part", [np.s_[:], np.s_[:, 256:]], ids=["whole", "half"])
def test_another_light_is_read_anew(gain, part):
    rgb8 = portrait().astype(float)
    rgb8[part] *= gain
    assert not is_used_again(scene_at(0), scene_at(1, rgb8=rgb8.clip(0, 255).astype(np.uint8)))


def test_noise_of_a_camera_is_no_other_light():
    noisy = portrait() + np.random.default_rng(0).normal(0, 3, portrait().shape)
    assert is_used_again(scene_at(0), scene_at(1, rgb8=noisy.clip(0, 255).astype(np.uint8)))


def test_a_mouth_that_hides_is_read_anew():
    hidden = scene_at(1)
    (face,) = hidden.faces
    hidden = replace(hidden, faces=(replace(face, face=replace(face.face, mouth_visible=0.5)),))
    assert not is_used_again(scene_at(0), hidden)


@pytest.mark.parametrize("pts", [-1, 0, 4, 300])
def test_a_surface_of_another_time_is_made_anew(pts):
    assert not is_used_again(scene_at(0), scene_at(pts))


def test_each_track_has_its_own_surface():
    assert not is_used_again(scene_at(0), scene_at(1, track_id=1))


@pytest.mark.parametrize("cut", [False, True])
def test_no_surface_is_used_across_a_cut(cut):
    composite = Composite(BLUSH)
    kept = composite._reader.kept
    composite(scene_at(0))
    (first,) = kept.values()
    composite(scene_at(1, cut=cut))
    (second,) = kept.values()
    assert (second.shading is first.shading) != cut


def test_rehearsal_leaves_no_surface_behind():
    composite = Composite(BLUSH)
    composite.rehearse(scene_at(0), BLUSH)
    assert not composite._reader.kept


def test_weights_of_a_resting_face_are_computed_once():
    composite = Composite(BLUSH)
    for pts in range(3):
        composite(scene_at(pts))
    (kept,) = composite._reader.kept.values()
    assert kept.uses == 2
    assert len(kept.surface.laid) == len(kept.surface.weights) == 1
