"""What holds for every look: the inside of the mouth stays as it is."""

import numpy as np
import pytest
from laws import GAPING_MOUTHS, OPEN_MOUTHS, WORN, sample_scenes, share_changed, true_px
from makeup import inside, paint_planes, scene_of, true_face
from makeup_video.pipeline.faces.topology import LIPS_INNER, LIPS_OUTER
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.look import Layer, Look


@pytest.mark.parametrize("finish", ["matte", "gloss", "shimmer"])
@pytest.mark.parametrize("number", OPEN_MOUTHS)
def test_little_of_an_open_mouth_changes(number, finish):
    """Less than a hundredth of a mouth changes visibly, of one that gapes less than a thirtieth.

    A twentieth may change by as little as 2 codes: px that mix lip and dark are painted in part.
    """
    look = Look(lips=product((180, 0, 46), finish))
    gapes = number in GAPING_MOUTHS
    assert share_changed(number, LIPS_INNER, 2, look, 12) < (0.03 if gapes else 0.01)
    assert share_changed(number, LIPS_INNER, 2, look) < 0.05


def test_little_of_a_mouth_that_opens_fast_changes():
    assert share_changed(185, LIPS_INNER, 2, WORN) < 0.08  # the net takes the tongue's edge for lip


@pytest.mark.parametrize("number", OPEN_MOUTHS)
def test_with_true_points_hardly_a_pixel_of_the_mouth_changes(number):
    scene = sample_scenes()[number]
    scene = scene_of(scene.frame, (true_face(true_px(number)),))
    old, new = scene.frame.planes[0], paint_planes(scene, WORN)[0]
    within = inside(true_px(number)[LIPS_INNER], old.shape, 2)
    assert (new != old)[within].mean() < 0.002


def test_pale_lipstick_goes_further_but_no_dark_rim():
    """The red goes on beyond the border, where it would be a rim around nude lipstick."""
    points = true_px(OPEN_MOUTHS[0])
    scene = scene_of(sample_scenes()[OPEN_MOUTHS[0]].frame, (true_face(points),))
    old = scene.frame.planes[0]
    beyond = ~inside(points[LIPS_OUTER], old.shape, 0.5)
    nude, changed = product((226, 188, 164), "matte"), []
    for colour, shape in (
        (nude, {}),
        (nude, {"rim": 0.01, "rim_color": "#46141A"}),
        (nude, {"rim": 1.0, "rim_color": "#46141A"}),
        (product((70, 20, 26), "matte"), {}),
    ):
        new = paint_planes(scene, Look([Layer("lipstick", colour, shape)]))[0]
        changed.append(np.count_nonzero((new != old)[beyond]))
    pale, hardly_lined, lined, dark = changed
    assert pale > 1.2 * max(lined, dark)
    assert hardly_lined > 0.95 * pale
