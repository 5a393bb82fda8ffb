"""Found faces are matched with lost ones: as many as possible, at the smallest distances."""

import math
from itertools import permutations

from hypothesis import example, given
from hypothesis import strategies as st
from makeup_video.pipeline.faces.matching import match

REACH = 1.5


def distances_of(rows, columns):
    row = st.lists(st.floats(0, 3) | st.just(math.inf), min_size=columns, max_size=columns)
    return st.lists(row, min_size=rows, max_size=rows)


def rank(distances, columns):
    """How many rows have no column, and the sum of the distances of the others."""
    own = [row[column] for row, column in zip(distances, columns, strict=True) if column >= 0]
    return len(columns) - len(own), sum(own)


def best(distances):
    """The lowest rank of all choices of columns for the rows; -1 stands for no column."""
    choices = permutations([*range(len(distances[0])), *[-1] * len(distances)], len(distances))
    return min(
        rank(distances, columns)
        for columns in choices
        if all(
            column < 0 or row[column] < REACH
            for row, column in zip(distances, columns, strict=True)
        )
    )


@given(st.tuples(st.integers(1, 4), st.integers(0, 4)).flatmap(lambda size: distances_of(*size)))
@example([[1.2, 1.0], [3.4, 1.2]])
@example([[3.4, 1.2], [1.2, 1.0]])
def test_no_other_choice_is_better(distances):
    columns = [-1 if column is None else column for column in match(distances, REACH)]
    taken = [column for column in columns if column >= 0]
    assert len(taken) == len(set(taken))
    assert all(
        column < 0 or row[column] < REACH for row, column in zip(distances, columns, strict=True)
    )
    (alone, total), (least_alone, least) = rank(distances, columns), best(distances)
    assert alone == least_alone and math.isclose(total, least, abs_tol=1e-6)


def test_nothing_is_matched_where_nothing_was_found_or_lost():
    assert match([], REACH) == []
    assert match([[], []], REACH) == [None, None]
