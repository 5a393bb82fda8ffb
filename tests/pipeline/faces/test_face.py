"""A face checks its points when it is made."""

import numpy as np
import pytest
from makeup_video.pipeline.faces.face import POINTS, Face, check_faces

REST = 1.0, 1.0, 0, None  # score, mouth_visible, track_id, lips
GOOD = np.zeros((POINTS, 3), np.float32)


@pytest.mark.parametrize(
    ("points_px", "got"),
    [
        (GOOD.tolist(), "got list"),
        (None, "got NoneType"),
        (GOOD[:10], r"got \(10, 3\) float32"),
        (GOOD.astype(np.float64), r"got \(478, 3\) float64"),
    ],
)
def test_points_of_another_type_or_shape_are_refused(points_px, got):
    with pytest.raises(ValueError, match=rf"points_px must be an array, \(478, 3\) float32, {got}"):
        Face(points_px, *REST)
    assert Face(GOOD, *REST).points_px is GOOD


@pytest.mark.parametrize(
    ("faces", "words"),
    [
        (0, r"faces must be a list of faces, got int: find_faces\(picture\) returns"),
        ("all", r"a face must be a Face, got str: find_faces\(picture\) returns"),
        (Face(GOOD, *REST), r"faces must be a list of faces, got one Face: give \[face\]"),
    ],
)
def test_what_is_no_list_of_faces_says_how_to_get_one(faces, words):
    with pytest.raises(TypeError, match=words):
        check_faces(faces)
