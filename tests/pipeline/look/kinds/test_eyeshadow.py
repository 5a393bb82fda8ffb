"""Where eyeshadow ends: below the eye, and at its outer end above it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import KINDS, product
from makeup_video.pipeline.look.kinds.fields import EyeChart

KIND = KINDS["eyeshadow"]
ACROSS = np.linspace(-0.4, 1.7, 211, dtype=np.float32)
HEIGHT = np.linspace(-1.4, 0, 141, dtype=np.float32)
BELOW = EyeChart(False, ACROSS[None, None, :], HEIGHT[None, :, None])
ABOVE = EyeChart(True, ACROSS[None, None, :], -HEIGHT[None, ::-1, None])  # from the lash line up


def density(at=BELOW, **shape):
    worn = product((90, 58, 46), "matte", "eyes")
    (coat,) = KIND.coats(at, worn, KIND.whole_shape(shape))
    return coat.density[0]


def depth(found, across):
    """How far below the lash line eyeshadow is seen, in heights."""
    dense = found[:, np.abs(ACROSS - across).argmin()] > 0.1
    return float(-HEIGHT[dense.argmax()]) if dense.any() else 0.0


@pytest.mark.parametrize("outer", [1.14, 1.25, 1.3])
def test_the_lower_border_rises_to_the_outer_end(outer):
    found = density(slot="under", outer=outer, low=-1.0)
    deepest, near, end = (depth(found, across) for across in (0.7, outer - 0.2, outer - 0.1))
    assert deepest > near > end
    assert end < 0.85 * deepest


@given(st.floats(-0.3, 1.6), st.floats(-0.3, 1.6), st.floats(-1.3, -0.1))
def test_any_borders_give_a_density(inner, outer, low):
    found = density(slot="under", inner=inner, outer=outer, low=low)
    assert np.isfinite(found).all() and found.min() >= 0 and found.max() <= 1 + 1e-6


@pytest.mark.parametrize("softness", [0.2, 0.5, 0.8])
def test_the_outer_end_leans_inwards_and_softens(softness):
    """Otherwise the end would be an upright edge on a lid that is half shut or turned away."""
    found = density(ABOVE, high=2.0, softness=softness)
    ends, slopes = [], []
    for row in found[:100:20, np.abs(ACROSS - 0.5).argmin() :]:
        share = row / row[0]
        ends.append(int((share > 0.5).sum()))
        slopes.append(float(-np.diff(share).min()))
    assert ends == sorted(ends, reverse=True) and ends[0] - ends[-1] > 8
    assert slopes == sorted(slopes, reverse=True) and slopes[-1] < 0.8 * slopes[0]


@given(st.floats(0, 1.5), st.floats(0.5, 1.6))
def test_a_wing_leans_less_the_more_it_rises(lift, outer):
    plain, raised = (density(ABOVE, outer=outer, lift=one, high=2.0) for one in (0.0, lift))
    over_the_eye = ACROSS <= 1  # further out a wing's lower border rises
    assert (raised >= plain - 1e-5)[:, over_the_eye].all()
