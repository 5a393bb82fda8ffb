"""A lipstick's colour, corrected by painting it on the photo that it was read from."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import Look, apply_look, find_faces, product
from makeup_video.pipeline.reference.correct_colour import SHEER, correct_colour
from makeup_video.pipeline.reference.estimate import photo_light
from people import portrait

CODES = st.integers(0, 255)


@cache
def face():
    return find_faces(portrait())[0]


def codes(params):
    return np.array([params.red, params.green, params.blue])


def correct(photo, params):
    return correct_colour(photo, face(), photo_light(photo, face()), params)


@pytest.mark.parametrize("rgb", [(180, 0, 46), (30, 60, 170), (60, 20, 40), (225, 205, 190)])
@pytest.mark.parametrize("wrong", [(40, 40, -40), (-40, 40, 40), (40, -40, 40)])
def test_a_misread_opaque_colour_gets_closer_to_the_truth(rgb, wrong):
    true = product(rgb, "satin")
    photo = apply_look(portrait(), Look(lips=true), [face()])
    red, green, blue = np.clip(np.add(rgb, wrong), 0, 255).astype(float)
    misread = replace(true, red=red, green=green, blue=blue)
    before = np.abs(codes(misread) - rgb).sum()
    assert np.abs(codes(correct(photo, misread)) - rgb).sum() < 0.75 * before


def test_only_the_colour_of_an_opaque_product_is_corrected():
    sheer = replace(product((180, 0, 46), "sheer"), opacity=SHEER)
    assert correct(portrait(), sheer) is sheer
    satin = product((180, 0, 46), "satin")
    corrected = correct(portrait(), satin)
    assert replace(corrected, red=180, green=0, blue=46) == satin


def test_lips_beyond_the_picture_are_not_corrected():
    satin = product((180, 0, 46), "satin")
    away = replace(face(), points_px=face().points_px + np.float32([5000, 0, 0]))
    moved = away.lips.to_px + np.array([[0, 0, 5000], [0, 0, 0]])
    away = replace(away, lips=replace(away.lips, to_px=moved))
    light = photo_light(portrait(), face())
    corrected = correct_colour(portrait(), away, light, satin)
    assert ((codes(corrected) >= 0) & (codes(corrected) <= 255)).all()


@settings(max_examples=25, deadline=None)
@given(CODES, CODES, CODES, st.floats(0, 1), st.floats(0, 4), st.floats(0, 1))
def test_any_product_gives_a_product_and_the_photo_stays(red, green, blue, opacity, gloss, mirror):
    given_product = replace(
        product((red, green, blue), "gloss"), opacity=opacity, gloss=gloss, reflection=mirror
    )
    photo = portrait().copy()
    corrected = correct(photo, given_product)
    assert ((codes(corrected) >= 0) & (codes(corrected) <= 255)).all()
    assert (photo == portrait()).all()
