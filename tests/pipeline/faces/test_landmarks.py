"""The plain-number shortcut of following is the least-squares fit that it stands for."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from makeup_video.pipeline.faces.face import LipPatch
from makeup_video.pipeline.faces.landmarks import FaceLandmarks, _is_odd, _step_of
from makeup_video.pipeline.faces.nets import View
from makeup_video.pipeline.faces.similarity import Similarity
from makeup_video.training.faces.similarity_fit import fit_similarity

MIDDLES = hnp.arrays(np.float64, (5, 2), elements=st.floats(-4000, 4000))


@given(MIDDLES, MIDDLES)
def test_a_step_is_the_similarity_between_the_rims(before, now):
    assume(np.hypot(*(before[3] - before[4])) > 1)
    want = fit_similarity(before[3:], now[3:])
    step = _step_of(*([complex(*xy) for xy in middles] for middles in (before, now)))
    got = [
        [step.turn.real, -step.turn.imag, step.shift.real],
        [step.turn.imag, step.turn.real, step.shift.imag],
    ]
    np.testing.assert_allclose(got, want, rtol=1e-6, atol=1e-4)


def sighting(moved: float, lips_at: complex = 0j, painted: int = 100) -> FaceLandmarks:
    logits = np.full((20, 20), -1.0, np.float32)
    logits.ravel()[:painted] = 1
    frame, centres = Similarity(100 + 0j, 0j), (lips_at, -30 - 40j, 30 - 40j)
    middles = [*centres, -30 - 40j, 30 - 40j]
    return FaceLandmarks(np.zeros(478, complex), np.zeros(478), (1.0, 1.0), frame,
                    LipPatch(logits, np.eye(2, 3)), View(frame, centres), middles, moved=moved)  # fmt: skip


@pytest.mark.parametrize(
    ("before", "found", "odd"),
    [
        (sighting(0.005), sighting(0.01), False),
        (sighting(0.005), sighting(0.01, lips_at=6 + 0j), True),  # they jump about the face
        (sighting(0.005), sighting(0.01, painted=45), True),  # they vanish
        (sighting(0.005), sighting(0.06), True),  # the film jerks
        (sighting(0.04), sighting(0.06), False),  # the head is moving
    ],
)
def test_what_is_odd_is_looked_at_again(before, found, odd):
    assert _is_odd(before, found) is odd
