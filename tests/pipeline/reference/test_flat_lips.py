"""Lips laid flat: the same for a mirror image and another size, and lipstick that stands out."""

from functools import cache

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import Look, find_faces, product
from makeup_video.pipeline.reference.flat_lips import FlatLips, flat_lips
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.render.apply_look import PaintPictures
from people import portrait
from reference_photos import face


@cache
def painter():
    return PaintPictures()


def lips_of(rgb8, found=None):
    found = face() if found is None else found
    return flat_lips(neutral_face(rgb8, found, photo_light(rgb8, found)))


def test_the_map_is_finite_and_gives_102_numbers():
    lips = lips_of(portrait())
    assert lips.roots.shape == (24, 16, 3) and lips.numbers().shape == (102,)
    assert np.isfinite(lips.numbers()).all()


def test_a_mirror_image_has_about_the_same_odds():
    mirrored = np.ascontiguousarray(portrait()[:, ::-1])
    (found,) = find_faces(mirrored)[:1]
    assert abs(lips_of(mirrored, found).log_odds() - lips_of(portrait()).log_odds()) < 1.5


def test_a_larger_photo_has_about_the_same_odds():
    twice = cv2.resize(portrait(), None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    (found,) = find_faces(twice)[:1]
    assert abs(lips_of(twice, found).log_odds() - lips_of(portrait()).log_odds()) < 1.5


@pytest.mark.parametrize("rgb", [(180, 0, 30), (120, 10, 60), (230, 90, 150)])
def test_lipstick_is_more_probable_on_painted_lips(rgb):
    painted = painter()(portrait(), Look(lips=product(rgb, "matte")), [face()])
    assert lips_of(painted).log_odds() > lips_of(portrait()).log_odds() + 2


@pytest.mark.parametrize("rgb", [(20, 40, 160), (15, 12, 14), (60, 160, 90), (240, 220, 60)])
def test_lips_in_colours_of_no_bare_ones_are_far_from_those(rgb):
    painted = painter()(portrait(), Look(lips=product(rgb, "matte")), [face()])
    assert lips_of(painted).away() > 4 > lips_of(portrait()).away()


def test_a_mirror_image_has_the_same_borders():
    lips = lips_of(portrait())
    mirrored = FlatLips(lips.roots[:, ::-1], lips.shape)
    np.testing.assert_allclose(mirrored.bands(), lips.bands(), atol=1e-6)
