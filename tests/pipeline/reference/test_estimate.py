"""A look from a photo: the same face gives the same look, and any net output gives a product."""

from dataclasses import fields
from functools import cache

import cv2
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import (
    FINISHES,
    GraphicsParams,
    Look,
    PhotoError,
    SeveralFacesError,
    apply_look,
    estimate_look,
    lip_mask,
    look_from_photo,
    product,
)
from makeup_video.pipeline.look.ciede2000 import ciede2000, lab_of
from makeup_video.pipeline.look.finishes import in_words
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.crops import (
    NUMBERS,
    crop_around,
    from_targets,
    input_places,
)
from makeup_video.pipeline.reference.estimate import (
    MOST_GLOSS,
    MOST_REFLECTION,
    estimate,
    estimate_photo,
    product_with,
)
from makeup_video.pipeline.reference.flat_lids import flat_rings
from makeup_video.pipeline.reference.read_makeup import WORN_FROM
from people import SAMPLES, grey, portrait, put
from reference_photos import face

SEVEN = st.tuples(
    st.floats(0, 1), *[st.floats(0, 255)] * 3, st.floats(0, 16), st.floats(0, 1), st.floats(0, 1)
)


@cache
def made_up():
    """(H, W, 3) uint8: the sample photo of a look."""
    return np.ascontiguousarray(cv2.imread(str(SAMPLES / "look.jpg"))[..., ::-1])


@cache
def sample_estimate():
    return estimate(made_up())


def difference(first, second):
    """The largest difference of the probabilities of two estimates, and of their lips' colours."""
    worn = max(abs(first.worn[kind] - second.worn[kind]) for kind in WORN_FROM)
    lips = [one.look.lips for one in (first, second)]
    if None in lips:
        return max(worn, float(lips[0] is not lips[1]))
    red, other = ([one.red, one.green, one.blue] for one in lips)
    return max(worn, np.abs(np.subtract(red, other)).max() / 255)


def test_a_look_is_estimated_with_all_its_settings():
    look = sample_estimate().look
    assert look.lips is not None and look.strength == 1
    assert estimate_look(made_up()) == look  # the only face
    assert Look.from_dict(look.to_dict()) == look


def test_a_kind_is_in_the_look_where_it_is_probable():
    for picture in (made_up(), portrait()):
        one = estimate(picture)
        assert all(0 <= probability <= 1 for probability in one.worn.values())
        worn = {layer.kind for layer in one.look.layers}
        assert worn <= {kind for kind, least in WORN_FROM.items() if one.worn[kind] >= least}


def test_glitter_on_the_lids_of_a_photo_is_read_as_shimmer():
    pale = Layer("eyeshadow", product("#9FD8E6", "matte", "eyes"), {"slot": "full"})
    plain = apply_look(portrait(), Look([Layer("lipstick", product("#B4002E", "satin")), pale]))
    to_px, _ = crop_around(face(), "eyes")
    rings = flat_rings()
    lids = input_places(face(), "eyes")[:, (rings > 0.3) & (rings < 1.5)].reshape(2, -1)
    specks = lids[:, np.random.default_rng(0).random(lids.shape[1]) < 0.06]
    x, y = np.rint(to_px[:, :2] @ specks + to_px[:, 2:]).astype(int)
    glitter = plain.copy()
    glitter[y, x] = 255
    matte, shining = (estimate(picture).look.of("eyeshadow") for picture in (plain, glitter))
    assert matte and not any(layer.product.shimmer for layer in matte)
    assert any(layer.product.shimmer > 0.1 for layer in shining)


def test_a_bare_face_wears_nothing():
    assert estimate_look(portrait()).is_bare


def test_a_file_gives_the_same_look_as_its_pixels(tmp_path):
    cv2.imwrite(str(tmp_path / "in.png"), made_up()[..., ::-1])
    assert look_from_photo(tmp_path / "in.png") == sample_estimate().look
    assert estimate_photo(tmp_path / "in.png", "0") == estimate_photo(
        tmp_path / "in.png", "largest"
    )


@pytest.mark.parametrize("ground", [(1600, 1400), (1500, 1900)])
def test_a_larger_background_gives_about_the_same_look(ground):
    picture = put(grey(*ground), made_up(), 200, 100)
    assert difference(estimate(picture), sample_estimate()) < 0.15


def test_a_mirrored_photo_gives_about_the_same_look():
    mirrored = np.ascontiguousarray(made_up()[:, ::-1])
    assert difference(estimate(mirrored), sample_estimate()) < 0.15


def test_a_larger_photo_gives_about_the_same_look():
    twice = cv2.resize(made_up(), None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    assert difference(estimate(twice), sample_estimate()) < 0.15


@pytest.mark.parametrize("hex_rgb", [(180, 0, 30), (20, 40, 160), (15, 12, 14)])
def test_an_opaque_lipstick_is_read_closer_than_bare_lips_are(hex_rgb):
    true = Look(lips=product(hex_rgb, "matte"))
    painted = apply_look(portrait(), true, [face()])
    read = Look(estimate_look(painted).of("lipstick"))
    repainted = apply_look(portrait(), read, [face()])
    where = lip_mask(portrait(), face()) > 0.5
    lab = [lab_of(picture[where]) for picture in (painted, repainted, portrait())]
    assert ciede2000(lab[0], lab[1]).mean() < ciede2000(lab[0], lab[2]).mean()


@settings(max_examples=10, deadline=None)
@given(st.tuples(*[st.integers(0, 255)] * 3), st.sampled_from(["matte", "satin", "gloss"]))
def test_lips_that_stand_out_and_are_not_red_are_made_up(rgb, finish):
    assume(rgb[0] <= max(rgb[1:]))
    painted = apply_look(portrait(), Look(lips=product(rgb, finish)), [face()])
    where = lip_mask(portrait(), face()) > 0.5
    off = ciede2000(lab_of(painted[where]), lab_of(portrait()[where]))
    assume(np.median(off) > 20)
    assert estimate(painted).worn["lipstick"] >= WORN_FROM["lipstick"]


def test_a_file_is_named_in_its_refusal(tmp_path):
    cv2.imwrite(str(tmp_path / "in.png"), np.dstack([grey(), np.full((360, 640), 255, np.uint8)]))
    with pytest.raises(PhotoError, match=r"in.png: no face was found"):
        look_from_photo(tmp_path / "in.png")


@pytest.mark.parametrize("bad", [portrait()[..., 0], portrait() / 255.0, portrait()[:0]])
def test_anything_but_an_rgb_picture_is_a_value_error(bad):
    with pytest.raises(ValueError, match="8-bit RGB"):
        estimate_look(bad)


def test_several_faces_come_with_the_argument_that_chooses(tmp_path):
    two = np.hstack([portrait(), portrait()])
    with pytest.raises(SeveralFacesError, match=r"give one of find_faces\(rgb8\) as `face`; there"):
        estimate_look(two)
    cv2.imwrite(str(tmp_path / "two.png"), two[..., ::-1])
    words = r'two.png: one face .* give face="largest" or the number of a face; there are 0 at \('
    with pytest.raises(SeveralFacesError, match=words) as raised:
        look_from_photo(tmp_path / "two.png")
    assert len(raised.value.faces) == 2
    with pytest.raises(SeveralFacesError, match=words):
        estimate_photo(tmp_path / "two.png")
    chosen = look_from_photo(tmp_path / "two.png", face="largest")
    assert chosen == estimate_photo(tmp_path / "two.png", 0).look


# -- seven numbers -> a product


@given(SEVEN, st.sampled_from(["lips", "eyes"]))
def test_a_finish_fills_in_what_the_net_does_not_give(numbers, region):
    got = product_with(np.array(numbers), region)
    most = [1, 255, 255, 255, MOST_GLOSS, 1, MOST_REFLECTION]
    kept = np.minimum(numbers, most)
    np.testing.assert_allclose([getattr(got, name) for name in NUMBERS], kept, atol=5.1e-4)
    rest = {spec.name: getattr(got, spec.name) for spec in fields(GraphicsParams)[7:]}
    assert rest["shimmer"] == 0
    assert rest in [
        {name: by_region[region][name] for name in rest} for by_region in FINISHES.values()
    ]


@given(st.lists(st.floats(-3, 9), min_size=7, max_size=7))
def test_any_output_of_a_net_gives_a_look(targets):
    for region in ("lips", "eyes"):
        assert in_words(product_with(from_targets(np.array(targets)), region), region)


@pytest.mark.parametrize(
    ("finish", "words"),
    [
        ("matte", "matte, opaque"),
        ("gloss", "glossy, opaque"),
        ("sheer", "sheer, light coverage"),
    ],
)
def test_a_product_is_described_in_words(finish, words):
    assert in_words(product((1, 2, 3), finish)) == words


def test_eyes_in_two_colours_wear_different_layers():
    """And looks in one colour have no layers of one eye."""
    for eyes in (("left", "right"), ("both",)):
        worn = [product((0, 110, 90), "matte", "eyes"), product((130, 20, 120), "matte", "eyes")]
        layers = [
            Layer("eyeshadow", one, {"slot": "full", "eye": eye})
            for one, eye in zip(worn, eyes, strict=False)
        ]
        lips = Layer("lipstick", product((150, 10, 40), "satin", "lips"))
        read = estimate_look(apply_look(portrait(), Look([*layers, lips]), [face()]))
        found = {layer.shape.get("eye", "both") for layer in read.of("eyeshadow")}
        assert found == set(eyes)
