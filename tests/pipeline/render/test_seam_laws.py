"""Where the skin above an eye and the skin below it meet, makeup goes on as if it were one surface.

The eye is open in frame 60 of the sample and shut in frame 75.
"""

import numpy as np
import pytest
from layers import job_weight, jobs
from makeup import close_up, product, scene_of, true_face, white_light
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.render.coats import PaintJob
from people import frame_of

BOX, SCALE = (200, 60, 440, 300), 3.0
STATES = {"open": 0.0, "half open": 0.6, "nearly shut": 0.85, "shut": 1.0}
# Above and below the eye, in one layer.
WHOLE = {"low": -0.7, "high": 1.3, "inner": -0.2, "outer": 1.35, "softness": 0.5}
NARROW = {**WHOLE, "low": -0.2}
CORNERS = (33, 133), (263, 362)  # outer, inner


def shadow(**shape):
    return Layer("eyeshadow", product(opacity=1.0), shape)


def points_at(shut):
    """Points between open eyes (0) and shut eyes (1), enlarged: eyes are 80 px wide."""
    opened, closed = (close_up(number, BOX)[1] for number in (60, 75))
    return (opened + shut * (closed - opened)) * SCALE


def eye_jobs(shut, layers):
    points = points_at(shut)
    side = round((BOX[2] - BOX[0]) * SCALE)
    skin = np.full((side, side, 3), (190, 140, 120), np.uint8)
    scene = scene_of(frame_of(skin), (true_face(points),), white_light())
    return points, side, jobs(scene, layers)


def coverages(made: list[PaintJob], side: int) -> dict[int, np.ndarray]:
    """By eye, (side, side): how much of the skin opaque products cover, one after another."""
    covered: dict[int, np.ndarray] = {}
    for job in made:
        bare = 1 - covered.get(job.surface.number, np.float32(0))
        covered[job.surface.number] = 1 - bare * (1 - job_weight(job, (side, side)))
    return covered


def lines_beside(points, outs):
    """(number of the eye, (60, 2) px): lines across the height of a corner, that many widths of the
    eye beyond it."""
    for number, (outer, inner) in enumerate(CORNERS):
        a, b = points[outer, :2], points[inner, :2]
        along = a - b
        down = np.array([-along[1], along[0]]) * np.sign(along[0])
        for corner, direction in ((a, along), (b, -along)):
            for out in outs:
                at = corner + out * direction
                yield number, at + np.linspace(-0.12, 0.12, 60)[:, None] * down


def along(image, line):
    x, y = np.rint(line).astype(int).T
    return image[y, x]


@pytest.mark.parametrize("shape", [WHOLE, NARROW], ids=["whole", "narrow"])
@pytest.mark.parametrize("state", STATES)
def test_one_layer_has_no_line_beside_the_corners(state, shape):
    """Coverage rises and falls once at most across the height of the corner: neither a bare line,
    where both lash lines end, nor a line that both sides paint."""
    points, side, made = eye_jobs(STATES[state], [shadow(**shape)])
    weights = coverages(made, side)
    seen = 0.0
    for number, line in lines_beside(points, (0.07, 0.12, 0.17)):
        values = along(weights[number], line)
        top = int(values.argmax())
        back = [
            np.maximum.accumulate(part) - part for part in (values[: top + 1], values[top:][::-1])
        ]
        assert max(part.max() for part in back) < 0.06
        assert np.abs(np.diff(values)).max() < 0.3  # from px to px: the narrow border itself
        seen = max(seen, values.max())
    assert seen > 0.5


def test_shadow_below_the_eye_ends_softly_beside_the_corner():
    """Beyond the corner there is no lash line at which its colour would end."""
    points, side, made = eye_jobs(0.0, [shadow(slot="under")])
    weights = coverages(made, side)
    for number, line in lines_beside(points, (0.08, 0.12)):
        assert np.abs(np.diff(along(weights[number], line))).max() < 0.2


def test_a_shut_eye_has_no_bare_line_between_its_corners():
    points, side, made = eye_jobs(1.0, [shadow(**WHOLE)])
    for number, weight in coverages(made, side).items():
        outer, inner = (points[corner, :2] for corner in CORNERS[number])
        for share in np.linspace(0.2, 0.8, 7):
            middle = outer + share * (inner - outer)
            column = weight[:, round(middle[0])]
            covered = np.flatnonzero(column > 0.6)
            assert column[covered.min() : covered.max()].min() > 0.6 and len(covered) > 20


def test_two_slots_that_meet_on_a_shut_eye_leave_no_bare_line():
    """Lid and under: where either fades at the lash line, the other covers."""
    _, side, made = eye_jobs(1.0, [shadow(slot="full"), shadow(slot="under")])
    for job in made:
        assert len(job.coats) == 2
        upper, lower = job.part.shares[:, :, 24]  # of opaque products
        rows = slice(int(np.flatnonzero(upper > 0.9).min()), int(np.flatnonzero(lower > 0.9).max()))
        assert (upper + lower)[rows].min() > 0.9
        assert job_weight(job, (side, side)).max() > 0.9
