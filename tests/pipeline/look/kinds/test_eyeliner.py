"""How eyeliner ends, and how its wing leaves it."""

import numpy as np
import pytest
from layers import SHOWN
from makeup import close_up_scene, device
from makeup_video.pipeline import KINDS, product
from makeup_video.pipeline.render.regions import REGIONS
from makeup_video.pipeline.render.surfaces.region import Reader

KIND = KINDS["eyeliner"]


def strokes(**shape):
    scene = close_up_scene()
    lits = REGIONS[KIND.surface].lit(scene, scene.faces[0], Reader(device()))
    fields = lits[0].surface.fields()
    worn = product((18, 14, 14), "matte", KIND.part)
    (coat,) = KIND.coats(fields, worn, KIND.whole_shape(shape))
    return coat.strokes


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
        across = np.minimum(wing.above, wing.below)  # half of it, where it lies
        heights.append(across.max())
    assert heights[0] < 0.7 * heights[2] and heights[0] < heights[1] < heights[2]


def test_both_ends_of_each_dial_are_finite():
    for dial in KIND.dials:
        for value in (dial.low, dial.high):
            shape = {**SHOWN.get("eyeliner", {}), dial.name: value}
            for stroke in strokes(**shape):
                assert np.isfinite(stroke.above).all() and np.isfinite(stroke.below).all()
