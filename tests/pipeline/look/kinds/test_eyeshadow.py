"""Where eyeshadow ends below the eye."""

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


def density(**shape):
    worn = product((90, 58, 46), "matte", "eyes")
    (coat,) = KIND.coats(BELOW, worn, KIND.whole_shape(shape))
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
