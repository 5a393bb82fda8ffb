"""Splits work among threads."""

import itertools


def split_evenly(count: int, groups: int) -> list[range]:
    """Split `count` items, in order, into groups of about equal size, none of them empty.

    groups: the most groups to make.
    """
    groups = min(count, groups)
    ends = [count * number // groups for number in range(groups + 1)] if groups else [0]
    return [range(first, end) for first, end in itertools.pairwise(ends)]
