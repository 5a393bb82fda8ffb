"""The reference net's training pictures: products in range, crops in place, true numbers."""

import csv
from functools import cache

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import white_light
from makeup_video.pipeline.faces.face import Face, moved
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.look.finishes import FINISHES, nearest_finish
from makeup_video.pipeline.reference.crops import (
    CROPPED,
    CROPS,
    NUMBERS,
    crop_around,
    divide_light,
    from_targets,
    input_places,
    to_targets,
)
from makeup_video.training.reference import draw_products, prepare, rendered_crops
from makeup_video.training.reference.people import People
from people import portrait

HEXES = ("#B4002E", "#C86E78", "#5A2A2A", "#E8A09A", "#8C1C3C", "#D2506E")


@cache
def face() -> Face:
    return find_faces(portrait())[0]


class OnePerson:
    """Stands in for People, with the sample's portrait."""

    share = np.ones(1)

    def __len__(self):
        return 1

    def rgb8(self, person):
        return portrait()

    def face(self, person):
        return face()


def table(path):
    """A shade table of every finish, and of none."""
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["brand", "product", "shade", "hex", "finish"])
        for number in range(200):
            finish = ("matte", "gloss", "glitter", "")[number % 4]
            rows.writerow(
                ["brand", "product", f"shade {number}", HEXES[number % len(HEXES)], finish]
            )
    return path


def mixture() -> draw_products.Mixture:
    rng = np.random.default_rng(3)
    return draw_products.Mixture(rng.random((100, 7)) * draw_products.MOST)


def renderer(region, seed=0, varied=True):
    return rendered_crops.Renderer(OnePerson(), region, mixture(), seed, varied)


def look(region, **numbers):
    given = {"opacity": 0.9, "red": 30, "green": 60, "blue": 200, "gloss": 0.5,
             "gloss_roughness": 0.5, "reflection": 0.1, **numbers}  # fmt: skip
    values = np.array([given[name] for name in NUMBERS], np.float64)
    return draw_products.look_of(values, draw_products.settings_of("satin", region), region)


def test_drawn_products_are_in_range_and_some_are_extreme():
    drawn = mixture().draw(5000, np.random.default_rng(0))
    assert (drawn >= 0).all() and (drawn <= draw_products.MOST).all()
    unworn = (drawn[:, [0, 4, 6]] == 0).all(1).mean()
    assert 0.5 * draw_products.BARE < unworn < 2 * draw_products.BARE
    blue = (drawn[:, 3] > 200) & (drawn[:, 1] < 60)
    assert blue.mean() > 0.01


def test_fitted_samples_resemble_what_they_were_fitted_on():
    values = np.tile([0.9, 180, 40, 60, 0.4, 0.5, 0.05], (50, 1))
    real = draw_products.Mixture(values).real(4000, np.random.default_rng(0))
    assert np.allclose(np.median(real, 0), values[0], atol=[0.05, 4, 4, 4, 0.06, 0.05, 0.03])


def test_normal_space_round_trip():
    values = np.random.default_rng(0).uniform(0.01, 0.99, (500, 7)) * draw_products.MOST
    assert np.allclose(draw_products.from_normal(draw_products.to_normal(values)), values, atol=0.6)


@given(st.lists(st.floats(0, 1), min_size=7, max_size=7))
def test_targets_round_trip_and_lie_between_0_and_1(parts):
    values = np.array(parts) * draw_products.MOST
    targets = to_targets(values)
    assert (targets >= 0).all() and (targets <= 1).all()
    assert np.allclose(from_targets(targets), values, atol=1e-9)


def test_net_outputs_beyond_their_ranges_are_clipped():
    numbers = from_targets(np.array([1.2, 1.5, -0.1, 0.5, 1.5, 2.0, -1.0]))
    assert np.allclose(numbers, [1, 255, 0, 127.5, 4, 1, 0])


@pytest.mark.parametrize("region", CROPPED)
def test_shade_tables_are_read_into_products_of_all_splits(tmp_path, region):
    products = draw_products.read_products(table(tmp_path / "shades.csv"), region)
    assert products.values.shape == (200, 7)
    assert set(products.split) == {0, 1, 2} and (products.split == 0).mean() > 0.5
    red = products.values[0, NUMBERS.index("red")]
    assert red == 0xB4
    gloss = [FINISHES[name][region]["gloss"] for name in ("matte", "gloss", "shimmer")]
    assert products.values[:3, NUMBERS.index("gloss")].tolist() == gloss


@pytest.mark.parametrize("region", CROPPED)
def test_every_finish_is_nearest_to_itself(region):
    for name, by_region in FINISHES.items():
        product_numbers = by_region[region]
        found = nearest_finish(
            product_numbers["opacity"],
            product_numbers["gloss"],
            product_numbers["gloss_roughness"],
            product_numbers["reflection"],
            region,
        )
        assert found == name


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.sampled_from(list(CROPPED)))
def test_drawn_settings_make_a_look(seed, region):
    rng = np.random.default_rng(seed)
    values = mixture().draw(1, rng)[0]
    made = draw_products.look_of(values, draw_products.draw_settings(values, region, rng), region)
    assert (made.lips or made.eyes).light_adaptation == 1


@pytest.mark.parametrize("region", CROPPED)
def test_an_unworn_product_leaves_the_crop_bare(region):
    crop_renderer = renderer(region, varied=False)
    shot = crop_renderer.shoot(0)
    painted = crop_renderer.paint(shot, look(region, opacity=0, gloss=0, reflection=0))
    assert (painted == rendered_crops.to_rgb8(shot.codes)).all()


@pytest.mark.parametrize("region", CROPPED)
def test_different_products_give_different_crops(region):
    crop_renderer = renderer(region, varied=False)
    shot = crop_renderer.shoot(0)
    before = shot.codes.copy()
    seen = [
        crop_renderer.see(shot, crop_renderer.paint(shot, look(region, **numbers)))
        for numbers in ({}, {"red": 200}, {"opacity": 0.3}, {"gloss": 3.0})
    ]
    assert (shot.codes == before).all()
    for at, crop in enumerate(seen):
        assert crop.shape[1::-1] == CROPS[region].input_wh and crop.dtype == np.uint8
        for other in seen[:at]:
            assert np.abs(crop.astype(int) - other).max() > 8


def test_a_red_and_a_blue_product_are_seen_as_red_and_blue():
    crop_renderer = renderer("lips", varied=False)
    shot = crop_renderer.shoot(0)
    for red, blue in ((200, 20), (20, 200)):
        wanted = np.array([red, 20, blue])
        matte = look("lips", opacity=1, gloss=0, reflection=0, red=red, green=20, blue=blue)
        crop = crop_renderer.see(shot, crop_renderer.paint(shot, matte)).astype(int)
        nearest = np.abs(crop - wanted).max(-1).min()
        assert nearest < 25


@pytest.mark.parametrize("region", CROPPED)
def test_the_same_seed_gives_the_same_crops(region):
    first, again, other = (renderer(region, seed).stream(looks=2) for seed in (5, 5, 6))
    for _ in range(4):
        a, b, c = next(first), next(again), next(other)
        assert (a[0] == b[0]).all() and (a[1] == b[1]).all()
        assert a[0].shape == c[0].shape and (a[0] != c[0]).any()


def test_batches_hold_every_crop_with_its_own_numbers():
    stream = renderer("lips", 1).stream()
    expected = {tuple(values): crop for crop, values, _ in (next(stream) for _ in range(8))}
    batches = renderer("lips", 1).batches(4, mix=2)
    for crops, values in (next(batches), next(batches)):
        for crop, numbers in zip(crops, values, strict=True):
            assert (expected.pop(tuple(numbers)) == crop).all()
    assert not expected


@pytest.mark.parametrize("region", CROPPED)
def test_a_crop_turns_and_grows_with_the_face(region):
    to_px, size_wh = crop_around(face(), region)
    c, s = 1.7 * np.cos(0.4), 1.7 * np.sin(0.4)
    turn = np.array([[c, -s, 40], [s, c, -9]])
    turned, same_size = crop_around(moved(face(), turn), region)
    assert same_size == size_wh
    corners = np.array([[0, size_wh[0], 0], [0, 0, size_wh[1]], [1, 1, 1]])
    wanted = turn[:, :2] @ (to_px @ corners) + turn[:, 2:]
    assert np.allclose(turned @ corners, wanted, atol=1e-3)


def test_crops_hold_what_they_are_for():
    for region, points in (("lips", [61, 291, 0, 17]), ("eyes", [33, 263, 159, 386, 105, 334])):
        to_px, (w, h) = crop_around(face(), region)
        back = cv2.invertAffineTransform(to_px)
        x, y = (face().points_px[points, :2] @ back[:, :2].T + back[:, 2]).T
        assert (x > 4).all() and (x < w - 5).all() and (y > 2).all() and (y < h - 3).all()


@pytest.mark.parametrize("region", CROPPED)
def test_the_pixels_of_a_net_input_lie_in_its_crop(region):
    _, (w, h) = crop_around(face(), region)
    places = input_places(face(), region)
    assert places.shape == (2, *CROPS[region].input_wh[::-1])
    assert (places >= 0).all() and (places[0] < w).all() and (places[1] < h).all()


def test_a_shifted_crop_keeps_its_middle_but_for_the_shift():
    to_px, size_wh = crop_around(face(), "lips")
    middle = np.array([(size_wh[0] - 1) / 2, (size_wh[1] - 1) / 2, 1])
    moved_to = rendered_crops.shifted((to_px, size_wh), 0.2, 1.1, np.array([3.0, -2.0])) @ middle
    assert np.allclose(moved_to, to_px @ (middle + np.array([3, -2, 0])))


def test_dividing_out_white_light_changes_nothing():
    rgb8 = np.random.default_rng(0).integers(0, 256, (8, 9, 3)).astype(np.uint8)
    light = white_light()
    assert (divide_light(rgb8, light) == rgb8).all()
    half = type(light)(light.colour, 0.5, light.direction, light.environment)
    assert (divide_light(rgb8, half) >= rgb8).all()


def test_made_up_mouths_stand_out_from_those_like_their_skin():
    rng = np.random.default_rng(0)
    skin = rng.uniform([40, 8, 12], [80, 18, 24], (90, 3))
    lips = skin * [0.85, 1.4, 0.8] + rng.normal(0, 0.8, (90, 3))
    lips[:20] += [-8, 25, 6]
    colours = np.column_stack([skin, lips, skin + rng.normal(0, 1, (90, 3)), np.full(90, 9.0)])
    colours[:, 9] += rng.normal(0, 1, 90)
    kept = prepare.bare(prepare.made_up(colours)["lips"], np.zeros(90, int))
    assert not kept[:20].any() and 50 <= kept.sum() <= 61


def test_a_black_and_white_portrait_is_left_out(tmp_path):
    grey = np.repeat(cv2.cvtColor(portrait(), cv2.COLOR_RGB2GRAY)[..., None], 3, axis=2)
    for name, rgb8, is_packed in (("colour", portrait(), True), ("grey", grey, False)):
        path = tmp_path / f"{name}.png"
        cv2.imwrite(str(path), rgb8[..., ::-1])
        assert (prepare.entry_of(path) is not None) == is_packed


def test_only_what_is_labelled_as_bare_is_painted(tmp_path):
    labels = {
        "none": "0,0,0,0,", "lips": "2,0,0,0,", "liner": "0,0,2,0,", "shadow": "1,2,0,0,",
        "unsure": "1,0,1,0,", "hidden": "0,0,0,0,h", "unusable": "0,0,0,0,x",
    }  # fmt: skip
    table = [f"{name}.jpg,{values}\n" for name, values in labels.items()]
    (tmp_path / "worn.csv").write_text("name,lips,shadow,liner,blush,flags\n" + "".join(table))
    names = [f"{name}.jpg" for name in (*labels, "unlabelled")]
    bare = prepare.labelled_bare(tmp_path, np.array(names))
    assert bare["lips"].tolist() == [True, False, True, *[False] * 5]
    assert bare["eyes"].tolist() == [True, True, *[False] * 6]
    colours = np.random.default_rng(0).normal(size=(len(names), 10))
    found = [
        {"picture": np.zeros(4, np.uint8), "tone": np.int64(0), "colours": each} for each in colours
    ]
    packed = prepare.pack(found, np.zeros(len(names), np.int64), bare)
    assert all((packed[f"bare_{region}"] == bare[region]).all() for region in CROPPED)


def test_every_source_of_people_is_split_by_its_order():
    picture = cv2.imencode(".png", portrait()[..., ::-1])[1].ravel()
    found = [
        {"picture": picture, "points": face().points_px,
         "logits": face().lips.logits.astype(np.float16), "to_px": face().lips.to_px,
         "colours": np.arange(10.0) + np.random.default_rng(number).normal(size=10),
         "tone": np.int64(number % 4 == 0)}
        for number in range(40)
    ]  # fmt: skip
    packed = prepare.pack(found, prepare.split_of(np.array(["a"] * 20 + ["b"] * 20)))
    assert packed["split"].tolist() == sorted(packed["split"][:20].tolist()) * 2
    assert set(packed["split"]) == {0, 1, 2}


def test_packed_people_are_read_back(tmp_path):
    picture = cv2.imencode(".png", portrait()[..., ::-1])[1].ravel()
    person = {"picture": picture, "points": face().points_px,
           "logits": face().lips.logits.astype(np.float16), "to_px": face().lips.to_px,
           "colours": np.zeros(10), "tone": np.int64(0)}  # fmt: skip
    tones = [0, 0, 0, 1]
    rng = np.random.default_rng(0)
    found = [{**person, "tone": np.int64(tone), "colours": rng.normal(size=10)} for tone in tones]
    packed = prepare.pack(found, np.zeros(4, np.int64))
    packed["bare_lips"] = np.ones(4, bool)
    np.savez(tmp_path / "people.npz", **packed)
    people = People(tmp_path / "people.npz", "lips", "train")
    assert len(people) == 4
    assert np.allclose(people.share[:3].sum(), people.share[3])
    assert (people.rgb8(2) == portrait()).all()
    assert (people.face(2).points_px == face().points_px).all()
