"""A look from a photo: the same face gives the same look, and any net output gives a product."""

from dataclasses import fields, replace
from functools import cache

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import (
    FINISHES,
    GraphicsParams,
    Look,
    PhotoError,
    apply_look,
    estimate_look,
    lip_mask,
    look_from_photo,
    product,
)
from makeup_video.pipeline.look.ciede2000 import ciede2000, lab_of
from makeup_video.pipeline.look.finishes import in_words
from makeup_video.pipeline.reference.crops import NUMBERS, from_targets, to_targets
from makeup_video.pipeline.reference.estimate import (
    BARE_GLOSS,
    BARE_OPACITY,
    BARE_REFLECTION,
    MOST_GLOSS,
    MOST_REFLECTION,
    product_of,
)
from people import clip, grey, portrait, put
from reference_photos import face

SEVEN = st.tuples(
    st.floats(0, 1), *[st.floats(0, 255)] * 3, st.floats(0, 16), st.floats(0, 1), st.floats(0, 1)
)


@cache
def portrait_look():
    return estimate_look(portrait(), face())


def compared_numbers(params):
    """Return the six numbers that are compared, on the nets' scale of 0 to 1.

    Gloss is left out, because more gloss than a lacquer's looks the same. Colours are weighted by
    opacity, because those of sheer products hardly show.
    """
    if params is None:
        return np.zeros(6)
    targets = to_targets([getattr(params, name) for name in NUMBERS])
    targets[1:4] *= targets[0]
    return np.delete(targets, NUMBERS.index("gloss"))


def difference(first, second):
    """Return the largest difference between two looks, on the nets' scale of 0 to 1."""
    regions = ((first.lips, second.lips), (first.eyes, second.eyes))
    return max(np.abs(compared_numbers(a) - compared_numbers(b)).max() for a, b in regions)


def test_a_look_is_estimated_with_all_its_settings():
    look = portrait_look()
    assert (look.strength, look.zone) == (1, "lid")
    assert [layer.strength for layer in look.layers] == [1, 1]
    assert look == estimate_look(portrait())  # the only face
    assert Look.from_dict(look.to_dict()) == look


def test_a_file_gives_the_same_look_as_its_pixels(tmp_path):
    cv2.imwrite(str(tmp_path / "in.png"), portrait()[..., ::-1])
    assert look_from_photo(tmp_path / "in.png") == estimate_look(portrait())
    assert look_from_photo(tmp_path / "in.png", "0") == look_from_photo(
        tmp_path / "in.png", "largest"
    )


@pytest.mark.parametrize("ground", [(1200, 900), (700, 1500)])
def test_a_larger_background_gives_about_the_same_look(ground):
    picture = put(grey(*ground), portrait(), ground[0] - 520, ground[1] - 640)
    assert difference(estimate_look(picture), portrait_look()) < 0.12


def test_a_mirrored_photo_gives_about_the_same_look():
    photo = clip(1)[0]
    assert difference(estimate_look(photo[:, ::-1]), estimate_look(photo)) < 0.12


def test_a_larger_photo_gives_about_the_same_look():
    twice = cv2.resize(portrait(), None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    assert difference(estimate_look(twice), portrait_look()) < 0.12


@pytest.mark.parametrize("hex_rgb", [(180, 0, 30), (20, 40, 160), (15, 12, 14)])
def test_an_opaque_lipstick_is_read_closer_than_bare_lips_are(hex_rgb):
    true = Look(lips=product(hex_rgb, "matte"))
    painted = apply_look(portrait(), true, [face()])
    repainted = apply_look(portrait(), replace(estimate_look(painted), eyes=None), [face()])
    where = lip_mask(portrait(), face()) > 0.5
    lab = [lab_of(picture[where]) for picture in (painted, repainted, portrait())]
    assert ciede2000(lab[0], lab[1]).mean() < ciede2000(lab[0], lab[2]).mean()


def test_a_file_is_named_in_its_refusal(tmp_path):
    cv2.imwrite(str(tmp_path / "in.png"), np.dstack([grey(), np.full((360, 640), 255, np.uint8)]))
    with pytest.raises(PhotoError, match=r"in.png: no face was found"):
        look_from_photo(tmp_path / "in.png")


@pytest.mark.parametrize("bad", [portrait()[..., 0], portrait() / 255.0, portrait()[:0]])
def test_anything_but_an_rgb_picture_is_a_value_error(bad):
    with pytest.raises(ValueError, match="8-bit RGB"):
        estimate_look(bad)


# -- seven numbers -> a product


@given(SEVEN, st.sampled_from(["lips", "eyes"]))
def test_a_finish_fills_in_what_the_net_does_not_give(numbers, region):
    got = product_of(np.array(numbers), region)
    opacity, _, _, _, gloss, _, reflection = numbers
    nothing = opacity < BARE_OPACITY - 1e-3 and gloss < BARE_GLOSS - 1e-3
    if got is None:
        assert opacity < BARE_OPACITY and gloss < BARE_GLOSS and reflection < BARE_REFLECTION
        return
    assert not (nothing and reflection < BARE_REFLECTION - 1e-3)
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
        got = product_of(from_targets(np.array(targets)), region)
        assert got is None or in_words(got, region)


@pytest.mark.parametrize(
    ("finish", "words"),
    [
        ("matte", "matte, opaque"),
        ("gloss", "glossy, opaque"),
        ("sheer", "soft sheen, fairly sheer"),
    ],
)
def test_a_product_is_described_in_words(finish, words):
    assert in_words(product((1, 2, 3), finish)) == words
