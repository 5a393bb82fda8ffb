"""Groups of about equal size, in order."""

from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.engine.split_evenly import split_evenly


@given(st.integers(1, 200), st.integers(1, 9))
def test_groups_share_the_items_evenly(count, most):
    groups = split_evenly(count, most)
    assert [index for group in groups for index in group] == list(range(count))
    sizes = [len(group) for group in groups]
    assert max(sizes) - min(sizes) <= 1 and len(sizes) == min(count, most)


def test_nothing_makes_no_groups():
    assert split_evenly(0, 3) == []
