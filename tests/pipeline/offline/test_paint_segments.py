"""Tests of pipeline/offline/paint_segments.py: the numbers of faces across segments."""

from types import SimpleNamespace

from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.offline.face_numbers import KnownFaces
from makeup_video.pipeline.offline.paint_segments import PaintedSegments

NUMBERS = st.dictionaries(st.integers(0, 9), st.integers(0, 9))


def two_segments(first, second, largest, known=None):
    """The first one saw the face `largest` as its largest; each with numbers of its own faces."""
    results = [SimpleNamespace(largest_id=largest), SimpleNamespace(largest_id=None)]
    return PaintedSegments(results, [first, second], known=[known, None])


@given(NUMBERS, NUMBERS, st.integers(0, 9))
def test_the_largest_face_before_is_named_as_in_the_video(first, second, largest):
    number = two_segments(first, second, largest).largest_before(1)
    assert number == first[largest] if largest in first else number < 0


@given(NUMBERS, st.integers(-9, 9))
def test_a_segment_that_knew_numbers_names_its_faces_by_them(numbers, largest):
    known = KnownFaces(numbers, None)
    assert two_segments(numbers, {}, largest, known).largest_before(1) == largest


def test_before_the_first_segment_no_face_is_the_largest():
    assert two_segments({0: 0}, {0: 0}, 0).largest_before(0) is None
