"""Numbers of faces in segments become those of the video."""

from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.offline.face_numbers import Sighting, VideoNumbers


def seen(numbers, frames=3):
    """Faces side by side, 100 px wide, each at the place of its number in `numbers`."""
    faces = tuple(Sighting(number, 200.0 * n, 50.0, 100.0) for n, number in enumerate(numbers))
    return {pts: faces for pts in range(frames) if faces}


@given(st.integers(0, 8), st.integers(0, 3), st.data())
def test_faces_seen_on_both_sides_keep_their_numbers(count, new, data):
    first = data.draw(st.permutations(range(count)))
    second = data.draw(st.permutations(range(count)))
    video = VideoNumbers()
    before = video.next({}, seen(first), sorted(first))
    assert before == {number: number for number in range(count)}
    later = [count + n for n in range(new)]
    numbers = video.next(seen(second), {}, [*sorted(second), *later])
    assert [numbers[own] for own in second] == first
    assert [numbers[own] for own in later] == later and video.count == count + new


def test_a_face_elsewhere_is_a_new_one():
    video = VideoNumbers()
    video.next({}, seen([0]), [0])
    assert video.next({0: (Sighting(0, 30.0, 50.0, 100.0),)}, {}, [0]) == {0: 1}


def test_a_face_of_the_run_up_alone_is_no_face_of_the_video():
    video = VideoNumbers()
    video.next({}, {}, [0])
    assert video.next(seen([0, 1]), seen([1]), [1]) == {1: 1} and video.count == 2


def test_frames_that_are_not_seen_again_are_forgotten():
    video = VideoNumbers()
    video.next({}, seen([0]), [0])
    video.forget_before(lambda pts: True)
    assert video.next(seen([0]), {}, [0]) == {0: 1}


def test_most_frames_decide_between_two_faces():
    """Two faces may cross in one frame."""
    one, other = (Sighting(n, 200.0 * n, 50.0, 100.0) for n in (0, 1))
    video = VideoNumbers()
    video.next({}, {0: (one, other), 1: (one, other), 2: (one,)}, [0, 1])
    own = one._replace(number=1), other._replace(number=0)
    crossed = other._replace(number=1)
    numbers = video.next({0: own, 1: own, 2: (crossed._replace(x_px=0.0),)}, {}, [0, 1])
    assert (numbers[1], numbers[0]) == (0, 1)


def test_two_faces_at_the_place_of_one_are_not_both_this_one():
    video = VideoNumbers()
    video.next({}, seen([0], 1), [0])
    beside = Sighting(1, 10.0, 50.0, 100.0)
    assert video.next({0: (*seen([0], 1)[0], beside)}, {}, [0, 1]) == {0: 0, 1: 1}
