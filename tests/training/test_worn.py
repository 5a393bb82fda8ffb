"""The training data of the net that tells what is worn, and the score it is judged by."""

import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import find_faces
from makeup_video.training.worn.crops import INPUT_WH, PLACES, mirrored, worn_input
from makeup_video.training.worn.prepare import LABELS, draw_look, painted, rows
from makeup_video.training.worn.scores import UNKNOWN, area_under_curve
from people import SAMPLES

PICTURE = np.ascontiguousarray(cv2.imread(str(SAMPLES / "portrait.jpg"))[..., ::-1])


def test_the_input_shows_eyes_face_and_lips():
    (face,) = find_faces(PICTURE)
    seen = worn_input(PICTURE, face)
    assert seen.shape == (*INPUT_WH[::-1], 3) and seen.dtype == np.uint8
    for left, top, wide, high in PLACES.values():
        assert np.ptp(seen[top : top + high, left : left + wide]) > 60
    np.testing.assert_array_equal(mirrored(mirrored(seen)), seen)
    assert (mirrored(seen) != seen).any()


def test_drawn_looks_are_labelled_by_what_they_change():
    (face,) = find_faces(PICTURE)
    rng = np.random.default_rng(3)
    found = set()
    for _ in range(6):
        look = draw_look(rng, {"lips": ["#B4002E"], "eyes": ["#5A3A2E"]})
        seen, labels = painted(PICTURE, face, look)
        assert seen.shape == (*INPUT_WH[::-1], 3)
        for label, kind in zip(labels, LABELS.values(), strict=True):
            assert label in (0, 1, UNKNOWN) and (label != 1 or look.of(kind))
            found.add(label)
    assert {0, 1} <= found


def test_labels_are_read_and_unusable_faces_left_out(tmp_path):
    (tmp_path / "worn.csv").write_text(
        "name,lips,shadow,liner,blush,flags\na.jpg,0,1,2,0,\nb.jpg,2,0,0,0,x\nc.jpg,0,2,0,0,h\n"
    )
    known = {path.name: labels for path, labels in rows(tmp_path)}
    assert known == {"a.jpg": [0, UNKNOWN, 1, 0], "c.jpg": [UNKNOWN, 1, UNKNOWN, UNKNOWN]}


@given(st.lists(st.tuples(st.integers(-50, 50), st.booleans()), min_size=2, max_size=40))
def test_the_area_is_the_share_of_pairs_in_the_right_order(pairs):
    scores = np.array([score for score, _ in pairs]) + np.arange(len(pairs)) * 1e-6  # no ties
    worn = np.array([is_worn for _, is_worn in pairs])
    if worn.all() or not worn.any():
        assert np.isnan(area_under_curve(scores, worn))
        return
    right = np.mean([a > b for a in scores[worn] for b in scores[~worn]])
    assert abs(area_under_curve(scores, worn) - right) < 1e-9
