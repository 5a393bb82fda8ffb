"""How eyeshadow lies on a lid that unfolds: charts of an open eye -> charts of a shut eye.

On an open eye the crease hides much of the lid, so a chart has only the colours beside the crease.
If the chart were stretched with the lid, the dark band of a smoky eye would become a bar with
upright ends. On a shut lid, as on a ball, colours lie dense along the lashes, and become fainter
and narrower towards the crease.
"""

from functools import cache

import cv2
import numpy as np
from makeup_video.kernels.shares import CHART_HEIGHT, CHART_ROWS, KEPT
from makeup_video.kernels.surface import LID_HW, LID_LEFT, LID_STEP
from makeup_video.pipeline.render.surfaces.surface import Charts

# A lid unfolds from this opening, in widths of the eye, to a shut eye, which shows all of its lid.
_OPENED = 0.25
# Steps of unfolding. The chart of a step is made when the first eye needs it. On a resting face the
# points move the opening by less than half a step.
STEPS = 32
# On a shut lid: how far the skin above the crease has come down, in heights, and how much narrower
# a colour is than at the lashes. Both are greatest in the crease, and 0 from the brow on.
_DOWN, _NARROWER = 0.225, 0.2
_MIDDLE = (0.05 - LID_LEFT) / LID_STEP  # the column towards which colours are narrower
# A chart knows little of skin that was folded, so it is blurred: sigma in columns and rows.
_SOFT_XY = 2.0, 0.22 * CHART_ROWS


def step_of(opening: float) -> int:
    """How far an eye's lid is unfolded: 0 for an open eye, STEPS for a shut one.

    opening: in widths of the eye.
    """
    shut = min(max(1 - opening / _OPENED, 0.0), 1.0)
    return round(STEPS * shut * shut * (3 - 2 * shut))


def unfolded(chart: np.ndarray, step: int) -> np.ndarray:
    """The chart (193, 48, coats) of the skin above an eye at a step of unfolding."""
    if step == 0:
        return chart
    share = np.float32(step / STEPS)
    columns, rows, bent = _places()
    x = columns + share * _NARROWER * bent * (columns - _MIDDLE)
    y = rows + share * (_DOWN * CHART_ROWS) * bent
    moved = cv2.remap(chart, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    wide, high = (float(share * sigma) for sigma in _SOFT_XY)
    soft = cv2.GaussianBlur(moved, (0, 0), wide, sigmaY=high, borderType=cv2.BORDER_REPLICATE)
    return soft.reshape(chart.shape)


def upper_charts(charts: Charts, steps: list[int]) -> list[np.ndarray]:
    """The charts of the skin above eyes at these steps; the charts made last are kept."""
    upper, made = charts.on_sides[0], charts.unfolded
    assert upper is not None
    found = []
    for step in steps:
        if step not in made:
            if len(made) == KEPT:
                del made[next(iter(made))]
            made[step] = unfolded(upper, step)
        found.append(made[step])
    return found


@cache
def _places() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(193, 48) float32 each: columns and rows of a chart, and how much a place moves: 0 at the
    lash line and from the brow on, 1 in the crease."""
    rows, columns = np.mgrid[: CHART_ROWS * CHART_HEIGHT + 1, : LID_HW[1]].astype(np.float32)
    height = np.minimum(rows / CHART_ROWS, 2)
    return columns, rows, height * (2 - height)
