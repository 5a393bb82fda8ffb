"""Blush is found by comparing it with the cheek around it, in any light."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import Look, product
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.cheeks import Cheeks, density, see_cheeks
from makeup_video.pipeline.reference.fit_blush import fit_blush
from makeup_video.pipeline.reference.flush import find_flush
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.render.apply_look import PaintPictures
from people import portrait
from reference_photos import face

ROSE = product((215, 60, 95), "matte", "blush")
APPLE = {"height": 0.0, "reach": 0.0, "size": 0.6}


@cache
def wearing(*layers):
    rgb8 = PaintPictures()(portrait(), Look(layers), [face()])
    return neutral_face(rgb8, face(), photo_light(rgb8, face()))


def bare_cheeks() -> Cheeks:
    """Cheeks just like those of the mean bare face, all of them seen."""
    seen = see_cheeks(wearing())
    everywhere = np.ones_like(seen.skin)
    return replace(seen, roots=seen.film().bare, skin=everywhere, visible=everywhere)


def reddened(shape, factors) -> Cheeks:
    """Bare cheeks with a patch in which each root changes by a factor."""
    cheeks = bare_cheeks()
    patch = density(cheeks, shape)[..., None]
    return replace(cheeks, roots=cheeks.roots * np.exp(patch * np.log(factors)))


def test_mean_bare_cheeks_have_no_flush():
    assert find_flush(bare_cheeks()) is None


@pytest.mark.parametrize("height", [0.0, 1.0])
@pytest.mark.parametrize("size", [0.3, 0.95])
def test_a_patch_is_found_where_it_is(height, size):
    shape = {"height": height, "reach": 0.4, "size": size, "across": 0.0}
    found = find_flush(reddened(shape, [1.0, 0.88, 0.92]))
    assert found.shape == shape
    assert found.red == pytest.approx(-2 * np.log(0.88), rel=0.1)
    assert found.blue == pytest.approx(2 * np.log(0.92 / 0.88), rel=0.1)


@settings(max_examples=20, deadline=None)
@given(st.tuples(*[st.floats(0.9, 1.1)] * 3))
def test_tinted_light_hardly_changes_a_flush(tint):
    cheeks = reddened(APPLE, [1.0, 0.88, 0.92])
    found = find_flush(replace(cheeks, roots=cheeks.roots * np.array(tint, np.float32)))
    assert found.red == pytest.approx(-2 * np.log(0.88), abs=0.08)


def test_a_shade_is_no_flush():
    assert find_flush(reddened(APPLE, [1.0, 0.95, 0.85])) is None


def test_cheeks_that_are_hidden_have_no_flush():
    cheeks = reddened(APPLE, [1.0, 0.88, 0.92])
    hidden = np.zeros_like(cheeks.skin)
    assert find_flush(replace(cheeks, skin=hidden, visible=hidden)) is None


def test_a_soft_rose_is_read_on_cheeks_in_pale_light():
    worn = wearing(Layer("blush", replace(ROSE, opacity=0.15), APPLE))
    cheeks = see_cheeks(worn)
    pale = replace(cheeks, roots=cheeks.roots * np.array([0.98, 1.14, 1.16], np.float32))
    (read,) = fit_blush(worn, pale, {})
    assert read.product.red > read.product.green + 60
    assert read.shape["height"] == APPLE["height"]
