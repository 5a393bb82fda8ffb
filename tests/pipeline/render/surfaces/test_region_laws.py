"""What holds for every region of the registry, whatever is worn there."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import close_up_scene, lit_of, paint_planes
from makeup_video.pipeline import FINISHES, Look, product
from makeup_video.pipeline.frames.affine import compose
from makeup_video.pipeline.look.regions import REGIONS
from makeup_video.pipeline.render.regions import PAINTED

NAMES = list(REGIONS)
DIALS = {
    name: st.fixed_dictionaries({
        dial.name: st.sampled_from(dial.choices) if dial.choices else st.floats(dial.low, dial.high)
        for dial in info.dials
    })
    for name, info in REGIONS.items()
}  # fmt: skip


def shape_of(name):
    return {dial.name: dial.default for dial in REGIONS[name].dials}


def surfaces_of(name):
    return close_up_scene().faces[0].regions[name]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("finish", list(FINISHES))
def test_every_finish_of_a_region_changes_the_picture(name, finish):
    scene = close_up_scene()
    before = [plane.copy() for plane in scene.frame.planes]
    look = Look(**{name: product((200, 20, 60), finish, name)})
    planes = paint_planes(scene, look)
    assert any((old != new).any() for old, new in zip(before, planes, strict=True))


@pytest.mark.parametrize("name", NAMES)
def test_a_product_without_effect_leaves_every_byte(name):
    scene = close_up_scene()
    before = [plane.copy() for plane in scene.frame.planes]
    bare = replace(product((200, 20, 60), "matte", name), opacity=0, gloss=0, reflection=0)
    for old, new in zip(before, paint_planes(scene, Look(**{name: bare})), strict=True):
        np.testing.assert_array_equal(old, new)


@pytest.mark.parametrize("name", NAMES)
def test_only_bytes_within_the_reach_of_a_region_change(name):
    scene = close_up_scene()
    before = scene.frame.planes[0].copy()
    worn = product((200, 20, 60), "gloss", name)
    after = paint_planes(scene, Look(**{name: worn}))[0]
    near = np.zeros(before.shape, bool)
    for lit in surfaces_of(name):
        low, high = lit.surface.reach(worn.edge_softness, shape_of(name))
        (left, top), (right, bottom) = np.floor(low).astype(int), np.ceil(high).astype(int) + 1
        near[max(top, 0) : max(bottom, 0), max(left, 0) : max(right, 0)] = True
    assert not ((before != after) & ~near).any()


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=25)
@given(data=st.data(), softness=st.floats(0, 1))
def test_weights_lie_between_0_and_1_for_every_dial(name, data, softness):
    shape = data.draw(DIALS[name])
    for lit in surfaces_of(name):
        out = np.full((400, 640), np.nan, np.float32)
        lit.surface.weigh(out, (0, 0), softness, shape)
        assert out.min() >= 0 and out.max() <= 1


@pytest.mark.parametrize("name", NAMES)
def test_a_scaled_surface_lies_on_the_scaled_picture(name):
    half = np.array([[0.5, 0, -0.25], [0, 0.5, -0.25]])
    for lit in surfaces_of(name):
        small = lit.surface.scaled(half)
        np.testing.assert_allclose(small.grid.to_px, compose(half, lit.surface.grid.to_px))
        np.testing.assert_array_equal(small.normals, lit.surface.normals)


@pytest.mark.parametrize("name", NAMES)
def test_light_and_amount_of_a_region_are_shares(name):
    scene = close_up_scene().faces[0]
    assert 0 <= PAINTED[name].amount(scene.face) <= 1
    for lit in lit_of(scene):
        assert 0 < PAINTED[name].shade(scene.light, lit.mean) <= 1
