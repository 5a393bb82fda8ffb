"""The plain-number shortcut of following is the least-squares fit that it stands for."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from makeup_video.pipeline.face_frame import fit_similarity
from makeup_video.pipeline.sighting import _step_of

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
