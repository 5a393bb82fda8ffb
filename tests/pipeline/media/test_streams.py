"""The size at which pixels that are not square are shown."""

from fractions import Fraction
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.media.streams import shown_wh


def shown(width, height, aspect):
    video = SimpleNamespace(codec_context=SimpleNamespace(width=width, height=height))
    source = SimpleNamespace(video=SimpleNamespace(sample_aspect_ratio=aspect))
    return shown_wh(video, source)


LARGE = st.integers(1, 1 << 31)


@given(st.integers(1, 16384), st.integers(1, 16384), LARGE, LARGE)
def test_any_aspect_ratio_has_numbers_for_matroska(width, height, across, down):
    size = shown(width, height, Fraction(across, down))
    if size is None:
        assert across == down
    elif isinstance(size, Fraction):
        assert size == Fraction(width * across, height * down)
    else:
        exact = min(max(width * across / down, 1), (1 << 32) - 1)
        assert size == (pytest.approx(exact, abs=0.5), height)
    if size is not None:
        numbers = size.as_integer_ratio() if isinstance(size, Fraction) else size
        assert min(numbers) > 0 and max(numbers) < 1 << 32


@pytest.mark.parametrize("aspect", [Fraction(1, 65535), Fraction(65535, 2)])
def test_extreme_aspect_ratios_stay_exact(aspect):
    size = shown(16, 4320, aspect)
    ratio = size if isinstance(size, Fraction) else Fraction(*size)
    assert ratio == Fraction(16 * aspect, 4320)
