"""Colours of words that name shades are medians over products of exactly that word."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.training.shade_names import LEAST, median_rgb

COLOURS = st.lists(st.tuples(*[st.integers(0, 255)] * 3), max_size=9)


def rows(name: str, colours: list[tuple[int, ...]]) -> list[dict[str, str]]:
    return [{"shade": name, "hex": "#" + bytes(colour).hex()} for colour in colours]


@given(COLOURS, COLOURS)
def test_a_word_has_the_median_colour_of_its_products(named, others):
    found = median_rgb("berry", rows("Very Berry 12", named) + rows("Strawberry", others))
    if len(named) < LEAST:
        assert found is None
    else:
        assert found == tuple(np.median(named, 0).astype(int))
