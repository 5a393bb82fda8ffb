"""Matches faces found now with faces that were lost a moment ago."""

from collections.abc import Sequence

_NEW = 1e3  # the cost of a new face: more than the distances of all faces within reach


def match(distances: Sequence[Sequence[float]], reach: float) -> list[int | None]:
    """For each face found now, the index of the lost face that it is; None for a new face.

    distances: a row for each face found now, with its distance to each lost face.
    As many faces as possible are matched, each with one less than `reach` away; of all ways to do
    so, the one with the least sum of distances counts. The order of the faces does not matter.
    """
    lost = len(distances[0]) if distances else 0
    # after the columns of the lost faces, one for each face found now: the choice that it is new
    costs = [
        [distance if distance < reach else _NEW for distance in row] + [_NEW] * len(distances)
        for row in distances
    ]
    row_of: dict[int, int] = {}
    for row in range(len(costs)):
        mover = row
        for column in _moves(costs, row_of, row):
            row_of[column], mover = mover, row_of.get(column, mover)
    matched: list[int | None] = [None] * len(costs)
    for column, row in row_of.items():
        if column < lost and costs[row][column] < _NEW:
            matched[row] = column
    return matched


def _moves(costs: list[list[float]], row_of: dict[int, int], newcomer: int) -> list[int]:
    """The columns of the cheapest moves that make room for a new row.

    The new row takes the first column, the row that had that column takes the second, and so on.
    The last column was free.
    """
    # for each column, the cheapest moves that end there: their cost and columns (Bellman, Ford)
    cheapest = [(cost, [column]) for column, cost in enumerate(costs[newcomer])]
    for _ in row_of:
        for column, row in row_of.items():
            before, moves = cheapest[column]
            for other, cost in enumerate(costs[row]):
                moved = before - costs[row][column] + cost
                if moved < cheapest[other][0] - 1e-9:  # rounding must not make the moves circular
                    cheapest[other] = moved, [*moves, other]
    return min(end for column, end in enumerate(cheapest) if column not in row_of)[1]
