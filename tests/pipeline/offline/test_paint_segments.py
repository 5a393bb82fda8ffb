"""Tests of pipeline/offline/paint_segments.py: the numbers of faces across segments."""

from types import SimpleNamespace

from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Report, Settings, ready_look
from makeup_video.pipeline.offline import split
from makeup_video.pipeline.offline.face_numbers import KnownFaces
from makeup_video.pipeline.offline.paint_segments import PaintedSegments

NUMBERS = st.dictionaries(st.integers(0, 9), st.integers(0, 9))


def two_segments(first, second, largest, known=None):
    """Two segments and their face numbers; the first saw the face `largest` as its largest."""
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


def part(span, **values):
    """The result of a segment, as far as the report of the video needs it."""
    report = Report("in.mp4", "segment", "h264", frames_in=3, **values)
    return SimpleNamespace(report=report, span=span, chosen_frames=0, painted_areas=())


def test_a_report_sums_up_what_its_segments_took():
    parts = [
        part((1, 2), first_packet_unix_seconds=9.0, peak_memory_bytes=7, tiny_faces=1,
             max_pts_error_seconds=0.25, stages={"encode": {"items": 3, "cpu_seconds": 0.5}}),
        part((2, 4), first_packet_unix_seconds=5.0, peak_memory_bytes=4, tiny_faces=2,
             stages={"encode": {"items": 4, "cpu_seconds": 1.0}}),
    ]  # fmt: skip
    painted = PaintedSegments(parts, [{}, {}], known=[None, None], cpu_seconds=4.0)
    report = Report("in.mp4", "out.mp4", "h264", cpu_seconds=1.0, peak_memory_bytes=6)
    split._add(report, painted, ready_look("cat-eye").look, Settings())
    assert (report.segments, report.media_seconds, report.tiny_faces) == (2, 3.0, 3)
    assert (report.cpu_seconds, report.peak_memory_bytes) == (5.0, 7)
    assert (report.max_pts_error_seconds, report.first_packet_unix_seconds) == (0.25, 5.0)
    assert report.stages == {"encode": {"items": 7, "cpu_seconds": 1.5}}
