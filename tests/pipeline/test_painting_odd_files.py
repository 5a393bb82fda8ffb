"""Painting what is unlike the usual file, face or caller."""

from dataclasses import replace

import numpy as np
import pytest
from makeup_video.pipeline import Look, Settings, apply_look, find_faces, process_video, product
from media import decoded
from people import clip, film, portrait

RED = Look(lips=product((180, 0, 46), "matte"))


@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuv422p", "yuv420p10le"])
@pytest.mark.parametrize("cut", [(0, 1), (1, 0), (1, 1)])
def test_lossless_films_of_odd_size_are_painted(tmp_path, pix_fmt, cut):
    pictures = [rgb8[cut[0] :, cut[1] :] for rgb8 in clip(2)]
    src = film(tmp_path / "in.mkv", pictures, pix_fmt)
    report = process_video(src, tmp_path / "out.mkv", RED, Settings(codec="ffv1"))
    assert report.painted_frames == 2 and report.warnings() == []
    assert decoded(tmp_path / "out.mkv")[0].width == pictures[0].shape[1]


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_face_without_a_place_is_left_alone(wrong):
    face = find_faces(portrait())[0]
    points = face.points_px.copy()
    points[7] = wrong
    painted = apply_look(portrait(), RED, [replace(face, points_px=points)])
    np.testing.assert_array_equal(painted, portrait())
    both = apply_look(portrait(), RED, [replace(face, points_px=points), face])
    np.testing.assert_array_equal(both, apply_look(portrait(), RED, [face]))
