"""What lies in front of the cheek is told from skin, and skin in any light is skin."""

from fractions import Fraction

import cv2
import numpy as np
import pytest
from lit_faces import face_at, lit, points, surface_made
from makeup_video.kernels.colour import SRGB, from_srgb_primaries, to_encoded, to_linear
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.render.skin_likeness_twin import skin_likeness
from people import frame_of, portrait

LEFT, RIGHT = 50, 280  # cheeks


def likeness_on(rgb8):
    """The surface of the face, and which of its places each cheek has, (40, 40) bool."""
    frame = frame_of(rgb8)
    surface, _, _ = surface_made(face_at(points()), frame)
    side = [
        (np.hypot(surface.across - x, surface.down - 0.33) < 0.12) & (surface.visible > 0.9)
        for x in (-0.42, 0.42)
    ]
    return surface, *side


def covered(colour, point=LEFT, radius=0.28):
    """The portrait with a disc of a colour over a cheek."""
    rgb8 = portrait().copy()
    iod_px = np.linalg.norm(points()[33, :2] - points()[263, :2])
    x, y = points()[point, :2].round().astype(int).tolist()
    cv2.circle(rgb8, (x, y), round(radius * iod_px), colour, -1)
    return rgb8


@pytest.mark.parametrize(
    "colour",
    [(20, 16, 14), (60, 45, 38), (70, 110, 190), (40, 120, 60), (128, 128, 128), (240, 244, 250)],
    ids=["black hair", "brown hair", "blue mask", "green", "grey", "a screen"],
)
def test_what_lies_on_a_cheek_is_no_skin_and_the_other_is(colour):
    surface, left, right = likeness_on(covered(colour))
    assert surface.likeness[left].mean() < 0.1
    assert surface.likeness[right].mean() > 0.95


def test_the_portraits_own_cheeks_are_skin():
    surface, left, right = likeness_on(portrait())
    assert surface.likeness[left].mean() > 0.93 and surface.likeness[right].mean() > 0.93


@pytest.mark.parametrize("gain", [(0.3, 0.3, 0.3), (1.0, 0.8, 0.55), (0.7, 0.8, 1.0)])
def test_skin_in_another_light_is_skin(gain):
    surface, left, right = likeness_on(lit(*gain))
    assert surface.likeness[left | right].mean() > 0.95


@pytest.mark.parametrize("primaries", [9, 12], ids=["BT.2020", "P3"])
def test_the_same_skin_in_wide_primaries_is_as_likely(primaries):
    rgb8 = covered((200, 120, 150))  # near to skin, so that primaries count
    wide = to_linear(rgb8 / 255, SRGB) @ from_srgb_primaries(primaries).T
    codes = np.rint(to_encoded(wide, SRGB) * 255).astype(np.uint8)
    picture, seconds = frame_of(codes, pix_fmt="yuv444p").picture, Fraction(1, 30)
    frames = (
        Frame(picture, 0, seconds, ColourTags(1, 1, 1, primaries)),
        frame_of(rgb8, pix_fmt="yuv444p"),
    )
    got, want = (surface_made(face_at(points()), frame)[0].likeness for frame in frames)
    off = np.abs(got - want)
    assert np.quantile(off, 0.9) < 0.01 and np.quantile(off, 0.99) < 0.15  # codes of eight bits


def test_skin_in_light_from_one_side_is_skin():
    across = np.linspace(-1, 1, portrait().shape[1])[None, :, None]
    linear = to_linear(portrait() / 255, SRGB) * np.exp(1.2 * across - 0.5)
    shaded = np.rint(to_encoded(np.clip(linear, 0, 1), SRGB) * 255).astype(np.uint8)
    surface, left, right = likeness_on(shaded)
    assert surface.likeness[left | right].mean() > 0.9


def test_a_flushed_cheek_is_skin():
    rgb8 = portrait().astype(np.float64)
    red = covered((255, 0, 255))[..., 1:2] != portrait()[..., 1:2]
    flushed = np.where(red, rgb8 * [1.03, 0.88, 0.92], rgb8)
    surface, left, _ = likeness_on(np.clip(flushed, 0, 255).astype(np.uint8))
    assert surface.likeness[left].mean() > 0.8  # the folds beside the nose are dark and red as well


def test_without_samples_everything_counts_as_skin():
    rgb = np.full((3, 50), 0.2, np.float32)
    place = np.zeros(50, np.float32)
    for seen in (np.arange(3), np.arange(0)):
        assert (skin_likeness(rgb, rgb[0], place, place, seen) == 1).all()


@pytest.mark.parametrize("light", [0.0, 1.0])
def test_a_black_or_white_picture_has_a_finite_likeness(light):
    rgb = np.full((3, 400), light, np.float32)
    across, down = np.random.default_rng(2).uniform(-0.5, 0.6, (2, 400)).astype(np.float32)
    like = skin_likeness(rgb, rgb[0], across, down, np.arange(400))
    assert np.isfinite(like).all() and like.min() == 1
