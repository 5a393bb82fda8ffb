"""Painting with unusual files, faces and calls."""

from dataclasses import replace

import numpy as np
import pytest
from makeup import close_up_scene, paint_planes, painter
from makeup_video.pipeline import Look, Settings, apply_look, find_faces, process_video, product
from makeup_video.pipeline.render.surfaces.eyes import LidSurface
from media import decoded
from people import clip, portrait, write_video

RED = Look(lips=product((180, 0, 46), "matte"))
EYES = product((0, 90, 40), "matte", "eyes")


@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuv422p", "yuv420p10le"])
@pytest.mark.parametrize("cut", [(0, 1), (1, 0), (1, 1)])
def test_lossless_videos_of_odd_size_are_painted(tmp_path, pix_fmt, cut):
    pictures = [rgb8[cut[0] :, cut[1] :] for rgb8 in clip(2)]
    src = write_video(tmp_path / "in.mkv", pictures, pix_fmt)
    report = process_video(src, tmp_path / "out.mkv", RED, Settings(codec="ffv1"))
    assert report.painted_frames == 2 and report.warnings() == []
    assert decoded(tmp_path / "out.mkv")[0].width == pictures[0].shape[1]


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_face_with_points_that_are_not_finite_is_skipped(wrong):
    face = find_faces(portrait())[0]
    points = face.points_px.copy()
    points[7] = wrong
    painted = apply_look(portrait(), RED, [replace(face, points_px=points)])
    np.testing.assert_array_equal(painted, portrait())
    both = apply_look(portrait(), RED, [replace(face, points_px=points), face])
    np.testing.assert_array_equal(both, apply_look(portrait(), RED, [face]))


def test_two_faces_of_one_number_have_their_own_light():
    dim = (portrait() * 0.3).astype(np.uint8)
    picture = np.concatenate([portrait(), dim], axis=1)
    (face,) = find_faces(portrait())
    to_px = face.lips.to_px + np.array([[0, 0, portrait().shape[1]], [0, 0, 0]])
    points = face.points_px + np.float32([portrait().shape[1], 0, 0])
    other = replace(face, points_px=points, lips=replace(face.lips, to_px=to_px))
    wanted = apply_look(picture, RED, [face, replace(other, track_id=face.track_id + 1)])
    np.testing.assert_array_equal(apply_look(picture, RED, [face, other]), wanted)


def test_a_look_set_during_a_frame_waits_for_the_next(monkeypatch):
    old = Look(eyes=EYES, zone="lid")
    scene = close_up_scene()
    wanted = paint_planes(scene, old)
    weigh = LidSurface.weigh

    def weigh_and_set(self, *rest):
        weigh(self, *rest)
        painter().set_look(Look(eyes=EYES, zone="full", strength=0.5))

    monkeypatch.setattr(LidSurface, "weigh", weigh_and_set)
    for new, plane in zip(paint_planes(scene, old), wanted, strict=True):
        np.testing.assert_array_equal(new, plane)
