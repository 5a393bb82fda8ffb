"""What holds for every kind: where it lies as eyes shut and heads turn, in videos of any layout."""

import cv2
import heads
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from laws import same
from layers import SHOWN, SLOTS, layer_weight, layers, shadow
from makeup import (
    LAYOUTS,
    close_up,
    copied,
    inside,
    paint_planes,
    product,
    scene_of,
    tagged,
    true_face,
    white_light,
)
from makeup_video.kernels.colour import HLG, PQ
from makeup_video.pipeline.faces.face import POINTS
from makeup_video.pipeline.faces.topology import EYE_CONTOUR, RIGHT_EYE
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer, Look
from people import frame_of
from plain_scenes import plain_scene, turned_head

any_kind = pytest.mark.parametrize("kind", KINDS)
on_eyes = pytest.mark.parametrize(
    "kind", [name for name, kind in KINDS.items() if kind.region == "eyes"]
)
SIZE = 440, 400
EYEBALLS = EYE_CONTOUR, RIGHT_EYE[: len(EYE_CONTOUR)]
BROWS = (
    [70, 63, 105, 66, 107, 55, 65, 52, 53, 46],
    [300, 293, 334, 296, 336, 285, 295, 282, 283, 276],
)
OPEN, SHUT = 60, 75  # frames of the sample
LASHES = 0.03  # of the eye's width: how far a line may reach over the lash line


def shown(kind, **shape):
    return Layer(kind, product(), {**SHOWN.get(kind, {}), **shape})


def head_of(number):
    """The true points of a frame of the sample, in the middle of a small picture."""
    points = heads.HEAD_PX[number][:, :2]
    return points - points.mean(0) + (SIZE[0] / 2, SIZE[1] / 2)


@on_eyes
@settings(max_examples=40, deadline=None)
@given(data=st.data(), number=st.sampled_from([0, OPEN, 100, 193]))
def test_nothing_lies_on_the_eyeball_in_any_shape(kind, data, number):
    points, layer = head_of(number), data.draw(layers(kind, opacity=1.0))
    weight = layer_weight(plain_scene(points, SIZE), layer)
    for contour in EYEBALLS:
        width_px = np.ptp(points[contour, 0])
        # pixels and the grid's columns cut the bends of a lash line
        shrunk_px = LASHES * width_px + 1 if KINDS[kind].is_line else 0.5
        within = inside(points[contour], weight.shape, shrunk_px)
        assert within.sum() > 150 and weight[within].max() == 0


@settings(max_examples=40, deadline=None)
@given(layers("eyeliner", opacity=1.0), st.sampled_from([0, SHUT, 193]))
def test_a_line_reaches_no_further_than_its_dials_say(layer, number):
    points, shape = head_of(number), layer.whole_shape
    weight = layer_weight(plain_scene(points, SIZE), layer)
    far = np.ones(weight.shape, bool)
    for contour in EYEBALLS:
        width_px = np.ptp(points[contour, 0])
        thick_px = 0.37 * shape["thickness"] * width_px
        smudged_px = 2 * shape["softness"] * thick_px
        # a tenth more: where the lash line is steep, distances are those of its slope
        reach_px = 1.15 * (shape["wing"] * width_px + thick_px + smudged_px) + 3
        far &= ~inside(points[contour], weight.shape, -reach_px)
    assert far.any() and weight[far].max() == 0


@on_eyes
@pytest.mark.parametrize("number", [0, OPEN, SHUT, 193])
def test_hair_of_the_brows_is_hardly_covered(kind, number):
    points = head_of(number)
    for slot in KINDS[kind].slots or (None,):
        layer = shown(kind) if slot is None else Layer(kind, product(), {"slot": slot})
        weight = layer_weight(plain_scene(points, SIZE), layer)
        for contour in BROWS:
            brow = weight[inside(points[contour], weight.shape)]
            assert brow.size > 150 and brow.mean() < 0.05 and brow.max() < 0.4
        assert weight.max() > 0.5


@on_eyes
def test_makeup_above_the_eye_follows_a_blink(kind):
    reach = []
    for number in (OPEN, SHUT):
        points = head_of(number)
        weight = layer_weight(plain_scene(points, SIZE), Layer(kind, product()))
        middle = points[[33, 133]].mean(0)
        column = weight[:, round(middle[0])]
        reach.append(np.flatnonzero(column > 0.3).max() - middle[1])
    assert reach[1] > reach[0] + 3


@on_eyes
def test_a_blink_does_not_change_how_strong_makeup_is(kind):
    """A lid grows as it closes, so that shadow spreads; a line stays as thick as it is."""
    opened, shut = (
        layer_weight(plain_scene(head_of(number), SIZE), Layer(kind, product())).sum()
        for number in (OPEN, SHUT)
    )
    assert 0.8 < shut / opened < (1.25 if KINDS[kind].is_line else 2.5)


@any_kind
@pytest.mark.parametrize("yaw_degrees", [-40, -25, 25, 40])
def test_makeup_stays_on_a_face_that_turns(kind, yaw_degrees):
    points = turned_head(yaw_degrees, 150, (SIZE[0] / 2, SIZE[1] / 2 - 40))
    straight = turned_head(0, 150, (SIZE[0] / 2, SIZE[1] / 2 - 40))
    with np.errstate(invalid="raise", divide="raise"):
        weight, whole = (
            layer_weight(plain_scene(one, SIZE), shown(kind)) for one in (points, straight)
        )
    assert 0.7 < weight.max() <= 1 and weight.min() >= 0
    assert 0.4 * whole.sum() < weight.sum() < 1.2 * whole.sum()
    outline = cv2.convexHull(points[:POINTS, :2].astype(np.float32))[:, 0]
    beyond = ~inside(outline, weight.shape, -0.05 * 150)
    assert weight[beyond].max() < 0.05
    for contour in EYEBALLS:
        within = inside(points[contour, :2], weight.shape, LASHES * 150 * 0.31 + 1)
        assert within.any() and weight[within].max() == 0


@any_kind
@pytest.mark.parametrize("yaw_degrees", [-88, -70, 70, 88])
def test_a_face_from_the_side_is_painted_without_a_warning(kind, yaw_degrees):
    points = turned_head(yaw_degrees, 60, (SIZE[0] / 2, SIZE[1] / 2))
    scene = plain_scene(points, SIZE)
    with np.errstate(invalid="raise", divide="raise", over="raise"):
        weight = layer_weight(scene, shown(kind))
        paint_planes(scene, Look([shown(kind)]))
    assert weight.min() >= 0 and weight.max() <= 1


def change(kind, pix_fmt, tags=None, cut=False):
    """The change of luma by a kind, in codes of 8 bits."""
    rgb8, points = close_up(box=(231, 83, 384, 270)) if cut else close_up()
    frame = frame_of(rgb8[:181, :113] if cut else rgb8, pix_fmt=pix_fmt)
    frame = tagged(frame, tags) if tags else frame
    scene = scene_of(frame, (true_face(points),), white_light())
    before, after = copied(frame), paint_planes(scene, Look([shown(kind)]))
    assert not same(before, after) and max(plane.max() for plane in after) < 2**frame.bit_depth
    assert not same(before[1:], after[1:])  # in colour, too
    return (after[0].astype(float) - before[0]) / 2 ** (frame.bit_depth - 8)


@any_kind
@pytest.mark.parametrize("pix_fmt", LAYOUTS)
@pytest.mark.parametrize("cut", [False, True], ids=["whole", "odd and cut off"])
def test_a_kind_is_painted_alike_in_every_layout(kind, pix_fmt, cut):
    want = change(kind, "yuv444p", cut=cut)
    got = change(kind, pix_fmt, cut=cut)
    assert np.abs(want).max() > 20
    difference = np.abs(got - want)[np.abs(want) > 2]
    # 8 bits are rounded twice, chroma is shared by up to four pixels, and a code more or less
    # decides in dark places whether a pixel counts as a lash
    assert difference.mean() < 1 and np.quantile(difference, 0.98) < 6


@any_kind
@pytest.mark.parametrize("transfer", [PQ, HLG])
def test_a_kind_is_painted_in_hdr(kind, transfer):
    moved = change(kind, "yuv420p10le", ColourTags(9, 1, transfer, 9))
    assert 2 < np.abs(moved).max() < 200


def test_slots_differ_from_each_other():
    scene = plain_scene(head_of(0), SIZE)
    weights = [layer_weight(scene, shadow(slot)) for slot in SLOTS]
    for at, one in enumerate(weights):
        for other in weights[at + 1 :]:
            assert np.minimum(one, other).sum() < 0.8 * max(one.sum(), other.sum())
