"""Numbers of faces in segments become those of the film."""

from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.offline.face_numbers import FaceNumbers, Sighting


def seen(numbers, frames=3):
    """Faces side by side, 100 px wide, each at the place of its number in `numbers`."""
    faces = tuple(Sighting(number, 200.0 * n, 50.0, 100.0) for n, number in enumerate(numbers))
    return {pts: faces for pts in range(frames) if faces}


@given(st.lists(st.integers(0, 40), unique=True, max_size=8), st.integers(0, 3), st.data())
def test_faces_seen_on_both_sides_keep_their_numbers(film, new, data):
    own = data.draw(st.permutations(range(len(film))))
    numbers = FaceNumbers(seen(film), next_number=41)
    numbers.match(seen(own))
    assert [numbers[number] for number in own] == film
    later = [len(film) + n for n in range(new)]
    numbers.take(later)
    assert [numbers[number] for number in later] == [41 + n for n in range(new)]
    assert numbers.next_number == 41 + new


def test_a_face_elsewhere_is_a_new_one():
    numbers = FaceNumbers(seen([5]), next_number=6)
    numbers.match({0: (Sighting(0, 30.0, 50.0, 100.0),)})
    assert numbers[0] == 6


def test_most_frames_decide_between_two_faces():
    """Two faces may cross in one frame."""
    one, other = (Sighting(n, 200.0 * n, 50.0, 100.0) for n in (0, 1))
    numbers = FaceNumbers({0: (one, other), 1: (one, other), 2: (one,)}, next_number=2)
    own = one._replace(number=1), other._replace(number=0)
    crossed = other._replace(number=1)
    numbers.match({0: own, 1: own, 2: (crossed._replace(x_px=0.0),)})
    assert (numbers[1], numbers[0]) == (0, 1)
