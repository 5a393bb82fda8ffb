"""How a line of eyeliner ends, and how its wing leaves the line."""

from copy import copy

import numpy as np
import pytest
from layers import SHOWN
from makeup import close_up_scene, device
from makeup_video.kernels.surface import LID_STEP
from makeup_video.pipeline import KINDS, product
from makeup_video.pipeline.render.regions import REGIONS
from makeup_video.pipeline.render.surfaces.region import Reader

KIND = KINDS["eyeliner"]


def open_eyes():
    scene = close_up_scene()
    lits = REGIONS[KIND.region].lit(scene, scene.faces[0], Reader(device()))
    return lits[0].surface.fields()


def strokes(at=None, **shape):
    worn = product((18, 14, 14), "matte", KIND.part)
    (coat,) = KIND.coats(at or open_eyes(), worn, KIND.whole_shape(shape))
    return coat.strokes


def upper(**shape):
    """(32, 48) bool: where an eye has a line or its wing."""
    both = strokes(**shape)[:2]
    return np.any([np.minimum(one.above, one.below)[0] > 0 for one in both], axis=0)


def columns(stroke):
    """(48,) the thickness of a line in every column of an eye's grid, px."""
    thick = (stroke.above + stroke.below)[0]
    assert np.ptp(thick, axis=0).max() < 1e-3  # the same whatever the row
    return np.maximum(thick[0], 0)


@pytest.mark.parametrize("thickness", [0.3, 0.6, 1.0])
def test_thick_lines_thin_to_their_end_without_a_stair(thickness):
    thick = columns(strokes(thickness=thickness)[0])
    lost = -np.diff(thick)[thick.argmax() :]
    assert thick[-1] == 0 and lost.max() < 0.45 * thick.max()


def test_wings_of_thin_lines_are_thin_as_well():
    heights = []
    for thickness in (0.03, 0.06, 0.12):
        _, wing = strokes(thickness=thickness, wing=0.4, wing_angle=45)[:2]
        across = np.minimum(wing.above, wing.below)  # at most half of its thickness
        heights.append(across.max())
    assert heights[0] < 0.7 * heights[2] and heights[0] < heights[1] < heights[2]


@pytest.mark.parametrize("angle", [10, 30, 50])
def test_wings_have_no_barb_below_the_outer_corner(angle):
    wing = {"wing": 0.3, "wing_angle": angle, "thickness": 0.15}
    rounded, pointed = upper(**wing), upper(**wing, lower=0.5)
    assert not (rounded & ~pointed).any()
    _, cut = np.nonzero(pointed & ~rounded)
    off = np.abs(open_eyes().across[cut] - 1)
    assert off.min() < 0.05 and off.max() < 0.3


def test_a_lower_line_meets_the_wing_in_the_corner():
    """Both end there, within a step of the grid."""
    _, wing, lower = strokes(wing=0.3, thickness=0.15, lower=0.5)
    wing, lower = (np.minimum(one.above, one.below)[0] for one in (wing, lower))
    step_px = float(open_eyes().width_px[0, 0, 0]) * LID_STEP
    beside = np.abs(open_eyes().across - 1) < 2 * LID_STEP
    assert np.minimum(wing, lower)[:, beside].max() > -step_px


def test_the_lower_line_does_not_lie_on_the_eye():
    eyes = open_eyes()
    line = strokes(lower=1.0, thickness=0.12)[1]
    drawn = np.minimum(line.above, line.below)[0] > 0
    middle = np.abs(eyes.across - 0.5) < 0.3
    assert drawn[:, middle].any() and not (drawn & (eyes.below_px[0] < 0))[:, middle].any()


@pytest.mark.parametrize("share", [1.0, 0.97])
def test_wings_of_shut_eyes_stay_whole(share):
    eyes = open_eyes()
    shut = copy(eyes)
    shut.below_px = -share * eyes.above_px
    whole, other = (strokes(shut, wing=0.3, thickness=0.1, lower=low)[1] for low in (0, 0.5))
    assert np.abs(whole.above - other.above).max() < 0.05 * float(eyes.width_px.max())


def test_both_ends_of_each_dial_are_finite():
    for dial in KIND.dials:
        for value in (dial.low, dial.high):
            shape = {**SHOWN.get("eyeliner", {}), dial.name: value}
            for stroke in strokes(**shape):
                assert np.isfinite(stroke.above).all() and np.isfinite(stroke.below).all()
