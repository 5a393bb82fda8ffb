"""Numbers of faces in segments become those of the film."""

from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.offline.face_numbers import FilmNumbers, Sighting


def seen(numbers, frames=3):
    """Faces side by side, 100 px wide, each at the place of its number in `numbers`."""
    faces = tuple(Sighting(number, 200.0 * n, 50.0, 100.0) for n, number in enumerate(numbers))
    return {pts: faces for pts in range(frames) if faces}


@given(st.integers(0, 8), st.integers(0, 3), st.data())
def test_faces_seen_on_both_sides_keep_their_numbers(count, new, data):
    first = data.draw(st.permutations(range(count)))
    second = data.draw(st.permutations(range(count)))
    film = FilmNumbers()
    before = film.next({}, seen(first), sorted(first))
    assert before == {number: number for number in range(count)}
    later = [count + n for n in range(new)]
    numbers = film.next(seen(second), {}, [*sorted(second), *later])
    assert [numbers[own] for own in second] == first
    assert [numbers[own] for own in later] == later and film.count == count + new


def test_a_face_elsewhere_is_a_new_one():
    film = FilmNumbers()
    film.next({}, seen([0]), [0])
    assert film.next({0: (Sighting(0, 30.0, 50.0, 100.0),)}, {}, [0]) == {0: 1}


def test_a_face_of_the_run_up_alone_is_no_face_of_the_film():
    film = FilmNumbers()
    film.next({}, {}, [0])
    assert film.next(seen([0, 1]), seen([1]), [1]) == {1: 1} and film.count == 2


def test_frames_that_are_not_seen_again_are_forgotten():
    film = FilmNumbers()
    film.next({}, seen([0]), [0])
    film.forget_before(lambda pts: True)
    assert film.next(seen([0]), {}, [0]) == {0: 1}


def test_most_frames_decide_between_two_faces():
    """Two faces may cross in one frame."""
    one, other = (Sighting(n, 200.0 * n, 50.0, 100.0) for n in (0, 1))
    film = FilmNumbers()
    film.next({}, {0: (one, other), 1: (one, other), 2: (one,)}, [0, 1])
    own = one._replace(number=1), other._replace(number=0)
    crossed = other._replace(number=1)
    numbers = film.next({0: own, 1: own, 2: (crossed._replace(x_px=0.0),)}, {}, [0, 1])
    assert (numbers[1], numbers[0]) == (0, 1)
