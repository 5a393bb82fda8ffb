"""The kernel that makes products ready for painting against its numpy twins."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import codings, device, lights, params, place_of, product, white_light
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.material_twin import Environment
from makeup_video.kernels.paint import FAINT, LAYERS
from makeup_video.kernels.product import LitRegion, ProductKernel
from makeup_video.pipeline.frames.affine import Affine
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.render.coats import WornCoat
from makeup_video.pipeline.render.product_twin import blend, environment_of, material
from makeup_video.pipeline.render.products import coat_records, coding_record

SHARES = st.just(0.0) | st.floats(1e-3, 1)
# without numbers so small that float32 would lose them
rounded = params().map(
    lambda p: replace(p, **{one.name: round(getattr(p, one.name), 4) for one in fields(p)})
)
coats = st.builds(WornCoat, st.sampled_from(list(KINDS.values())), rounded, SHARES)
worn = st.lists(st.tuples(coats, st.just(0.0) | st.floats(0.01, 3000)), min_size=1, max_size=LAYERS)
places = st.tuples(
    st.floats(-3.2, 3.2), st.floats(4, 1500), st.floats(0.3, 20), st.floats(-300, 300)
)
near = {"rtol": 2e-4, "atol": 2e-5}


def to_px(angle, skin_px, step, off):
    """The map from px of a grid of square steps to px of the rectangle."""
    (a, b), (c, d) = np.array(place_of(angle, skin_px).turn) * step
    return Affine(a, b, off, c, d, -off)


def lit_region(given_coats, amount, light, place, shade=1.0):
    return LitRegion(
        to_px(*place), place[1], coat_records(tuple(coat for coat, _ in given_coats)),
        amount, light.strength_for_products * shade, light.colour, light.direction,
        light.environment,
        [seen for _, seen in given_coats],
    )  # fmt: skip


def made(regions, coding):
    products, words = device().once(ProductKernel)(regions, coding_record(coding))
    count = len(regions)
    return products[:count].copy(), words[:count].copy()


def twin(given_coats, amount, light, place, coding, shade):
    """The layers and the material of `blend`, and the environment."""
    materials = [
        material(
            coat.product, coat.strength * amount, light, place_of(*place[:2]), coding,
            coat.kind.spared, shade, coat.kind.kept_highlights(coat.product),
        )
        for coat, _ in given_coats
    ]  # fmt: skip
    shares = np.array([seen for _, seen in given_coats], np.float32)[:, None, None]
    layers, common = blend(shares, materials)
    mirror = max((coat for coat, _ in given_coats), key=lambda coat: coat.product.reflection)
    return layers, common, environment_of(light.environment, mirror.product, coding)


def numbers(record):
    return np.hstack([np.ravel(record[name]) for name in record.dtype.names])


@settings(max_examples=150, deadline=None)
@given(worn, SHARES, lights(), places, codings(), st.floats(0.05, 1))
def test_products_match_their_twins(given_coats, amount, light, place, coding, shade):
    region = lit_region(given_coats, amount, light, place, shade)
    (product,), _ = made([region], coding)
    layers, common, _ = twin(given_coats, amount, light, place, coding, shade)
    np.testing.assert_allclose(numbers(product["material"]), np.hstack(common.record()), **near)
    if len(given_coats) == 1:
        assert product["layer_count"] == 0
        return
    assert product["layer_count"] == len(given_coats)
    rows = product["layers"]
    np.testing.assert_allclose(rows[: len(given_coats)], layers.numbers, **near)
    assert not rows[len(given_coats) :].any()
    np.testing.assert_allclose(product["mean_root"] / FAINT, layers.mean_root, **near)


@settings(max_examples=100, deadline=None)
@given(worn, lights(), places, codings())
def test_what_is_mirrored_matches_its_twin(given_coats, light, place, coding):
    (product,), (words,) = made([lit_region(given_coats, 1.0, light, place)], coding)
    *_, want = twin(given_coats, 1.0, light, place, coding, 1.0)
    assert product["room_step"] == pytest.approx(want.step, rel=1e-4, abs=1e-9)
    if want.step:  # otherwise the words are not read
        got = Environment(words.view(np.uint32).reshape(16, 16), float(product["room_step"]))
        np.testing.assert_allclose(got.linear(), want.linear(), atol=1.5 * want.step)


@settings(max_examples=100, deadline=None)
@given(places)
def test_places_on_the_grid_and_on_the_skin_match_their_maps(place):
    (product,), _ = made([lit_region(PLAIN, 1.0, white_light(), place)], Coding())
    there = to_px(*place)
    back = np.reshape(product["to_grid"], (2, 3)).astype(float)
    for x, y in ((0.0, 0.0), (40.0, 7.0), (3.0, 31.0)):
        a, b, left, c, d, top = there
        px = np.array([a * x + b * y + left, c * x + d * y + top, 1.0])
        np.testing.assert_allclose(back @ px, (x, y), atol=2e-3)
    per_grid = np.hypot(there.a, there.c) / place[1]
    np.testing.assert_allclose(product["to_patch"], product["to_grid"] * per_grid, 1e-5, 1e-9)


PLAIN = [(WornCoat(KINDS["lipstick"], product(), 1.0), 1.0)]


def test_regions_do_not_depend_on_each_other():
    one = lit_region(PLAIN, 1.0, white_light(), (0.1, 200, 3, 9))
    shiny = WornCoat(KINDS["eyeshadow"], product(red=20, gloss=1.0, reflection=0.5), 0.7)
    other = lit_region([*PLAIN, (shiny, 4.0)], 0.5, white_light(), (1.0, 90, 2, 5))
    regions = [one, other] * 8  # more than the buffers have room for at first
    together, words = made(regions, Coding())
    for number, region in enumerate(regions):
        (alone,), (word,) = made([region], Coding())
        for name in ("to_patch", "to_grid", "room_step", "layer_count"):
            np.testing.assert_array_equal(together[number][name], alone[name])
        got, want = (numbers(one["material"]) for one in (together[number], alone))
        np.testing.assert_array_equal(got, want)
        if alone["room_step"]:
            np.testing.assert_array_equal(words[number], word)


def test_a_region_that_shows_no_coat_is_finite():
    region = lit_region([(coat, 0.0) for coat, _ in PLAIN * 3], 1.0, white_light(),
                        (0, 100, 2, 0))  # fmt: skip
    (product,), _ = made([region._replace(seen=(0.0, 0.0, 0.0))], Coding())
    assert np.isfinite(np.hstack([numbers(product["material"]), product["mean_root"]])).all()
