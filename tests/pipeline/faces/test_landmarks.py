"""The tracker's shortcut in plain numbers equals the least-squares fit."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from makeup_video.pipeline.faces.face import LipPatch
from makeup_video.pipeline.faces.landmarks import FaceLandmarks, _is_odd, _step_between
from makeup_video.pipeline.faces.nets import CropLayout
from makeup_video.pipeline.faces.similarity import Similarity
from makeup_video.training.faces.similarity_fit import fit_similarity

CENTRES = hnp.arrays(np.float64, (5, 2), elements=st.floats(-4000, 4000))


@given(CENTRES, CENTRES)
def test_a_step_is_the_similarity_between_the_rims(before, now):
    assume(np.hypot(*(before[3] - before[4])) > 1)
    want = fit_similarity(before[3:], now[3:])
    step = _step_between(*([complex(*xy) for xy in centres] for centres in (before, now)))
    np.testing.assert_allclose(step.array(), want, rtol=1e-6, atol=1e-4)


def landmarks(moved: float, lips_at: complex = 0j, painted: int = 100) -> FaceLandmarks:
    logits = np.full((20, 20), -1.0, np.float32)
    logits.ravel()[:painted] = 1
    pose, centres = Similarity(100 + 0j, 0j), (lips_at, -30 - 40j, 30 - 40j)
    return FaceLandmarks(
        np.zeros(478, complex), np.zeros(478), (1.0, 1.0), pose, LipPatch(logits, np.eye(2, 3)),
        CropLayout(pose, centres), [*centres, -30 - 40j, 30 - 40j], moved=moved,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("before", "found", "odd"),
    [
        (landmarks(0.005), landmarks(0.01), False),
        (landmarks(0.005), landmarks(0.01, lips_at=6 + 0j), True),  # the lips jump
        (landmarks(0.005), landmarks(0.01, painted=45), True),  # the lips vanish
        (landmarks(0.005), landmarks(0.06), True),  # the film jerks
        (landmarks(0.04), landmarks(0.06), False),  # the head is moving
    ],
)
def test_odd_landmarks_are_read_again(before, found, odd):
    assert _is_odd(before, found) is odd
