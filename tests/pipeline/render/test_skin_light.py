"""The light on a face in one frame: its colour, strength and direction."""

from fractions import Fraction

import av
import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lit_faces import assert_sane, face_at, light, lit, points
from makeup_video.kernels.colour import (
    HLG,
    PQ,
    SRGB,
    encode,
    from_srgb_primaries,
    rounded,
    to_encoded,
    to_linear,
)
from makeup_video.pipeline import Layer, Look, apply_look, product
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.frames.colour_tags import ColourTags, resolve
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.views import FramePicture
from makeup_video.pipeline.look.ciede2000 import lab_of
from makeup_video.pipeline.render.scene_light import light_of
from makeup_video.pipeline.render.skin_light import SKIN_POINTS, TRIANGLES
from people import frame_of, portrait

CAST = st.tuples(*[st.floats(0.02, 3.0)] * 3)


def warmth(light):
    return float(np.log(light.colour[0] / light.colour[2]))


def test_an_ordinary_portrait_has_nearly_white_light():
    estimate = light(portrait())
    assert_sane(estimate)
    assert 0.8 < estimate.strength < 1.25
    assert np.abs(estimate.colour - 1).max() < 0.2
    assert estimate.colour @ [0.2126, 0.7152, 0.0722] == pytest.approx(1, abs=1e-3)


def test_a_darker_picture_of_the_same_face_means_weaker_light():
    strengths = [light(lit(gain, gain, gain)).strength for gain in (0.12, 0.25, 0.5, 0.75, 1, 1.2)]
    assert strengths == sorted(strengths)
    assert strengths[2] < 0.8 * strengths[4] and strengths[1] < 0.8 * strengths[2]


def on_skin(depth):
    """The portrait as if its skin were darker: along the line of real skin, not of exposure."""
    skin = lit(*np.exp(-depth * np.array([0.52, 0.75, 1.0])))
    mask = np.zeros(portrait().shape[:2], np.uint8)
    cv2.fillConvexPoly(mask, cv2.convexHull(points()[:, :2].astype(np.int32)), 1)
    return np.where(mask[..., None] > 0, skin, portrait())


def test_darker_skin_is_not_taken_for_dim_light():
    dark_face, dim = on_skin(0.9), lit(*[float(np.exp(-0.9 * 0.75))] * 3)
    assert light(dark_face).strength > 0.85 * light(portrait()).strength
    assert light(dim).strength < 0.75 * light(portrait()).strength
    assert abs(warmth(light(dark_face)) - warmth(light(portrait()))) < 0.1


def test_veils_share_what_makes_skin_darker_and_warmer():
    lights = [light(on_skin(depth)) for depth in (-0.6, 0.0, 0.5, 1.0, 1.5)]
    shares = [one.veil_share for one in lights]
    assert shares == sorted(shares, reverse=True) and shares[0] > 0.95 and 0.5 < shares[-1] < 0.85
    warmer = [warmth(one.for_veils) - warmth(one) for one in lights]
    assert warmer == sorted(warmer) and warmer[0] < 0.25 and warmer[-1] > 0.6


@settings(max_examples=15, deadline=None)
@given(gain=CAST)
def test_veils_on_pale_skin_have_the_light_of_the_face(gain):
    pale = light(lit(*gain))
    if pale.veil_share > 1 - 1e-9:  # no channel is darker than that of typical skin
        np.testing.assert_allclose(pale.veil_colour, pale.colour, atol=1e-5)
    assert 0.4 < pale.veil_share <= 1


@pytest.mark.parametrize("depth", [0.5, 1.0, 1.5])
def test_a_pink_blush_stays_a_pink_on_darker_skin(depth):
    """In the colours of pale skin it would be lilac on tanned skin, and ashes on dark skin."""
    pink = Look([Layer("blush", product((219, 130, 142), "matte", "blush"))])
    bare = on_skin(depth)
    changed = lab_of(apply_look(bare, pink, [face_at(points())])) - lab_of(bare)
    off = np.linalg.norm(changed, axis=-1)
    lightness, red, yellow = changed[off > 0.6 * off.max()].mean(0)
    assert lightness < 1 and red > 2.5 and yellow > -4


def test_a_warm_cast_gives_warm_light_and_a_blue_one_blue():
    plain = warmth(light(portrait()))
    for gain in ((1.35, 1, 0.6), (1.2, 0.8, 0.4), (0.6, 0.9, 1.3), (0.5, 0.6, 0.9)):
        cast = np.log(gain[0] / gain[2])
        shift = warmth(light(lit(*gain))) - plain
        assert 0.5 < shift / cast < 1.2


@pytest.mark.parametrize("matrix", [1, 5])
@pytest.mark.parametrize("full_range", [False, True])
@pytest.mark.parametrize("pix_fmt", ["yuv420p", "nv12", "yuv422p", "yuv444p", "yuv420p10le"])
def test_the_same_picture_in_any_layout_has_the_same_light(pix_fmt, full_range, matrix):
    want = light(portrait(), pix_fmt="yuv444p", full_range=True)
    got = light(portrait(), pix_fmt=pix_fmt, full_range=full_range, matrix=matrix)
    # chroma is coarser, and single pixels are sampled
    assert got.strength == pytest.approx(want.strength, rel=0.02)
    np.testing.assert_allclose(got.colour, want.colour, atol=0.02)
    np.testing.assert_allclose(got.direction, want.direction, atol=0.03)
    assert np.abs(got.environment - want.environment).mean() < 0.01


@pytest.mark.parametrize("transfer", [PQ, HLG])
def test_hdr_shows_the_same_light_in_its_own_primaries(transfer):
    tags = ColourTags(9, 1, transfer, 9)
    height_px, width_px = portrait().shape[:2]
    linear = to_linear(portrait() / 255, SRGB) @ from_srgb_primaries(9).T
    coding = resolve(tags, width_px, height_px, 10)
    codes = rounded(encode(linear, coding), coding).astype(np.uint16)
    picture = av.VideoFrame(width_px, height_px, "yuv444p10le")
    frame = Frame(picture, 0, Fraction(1, 30), tags)
    for plane, values in zip(frame.writable_planes(), np.moveaxis(codes, 2, 0), strict=True):
        plane[:] = values
    (got,) = light_of(FrameFaces(frame, (face_at(points()),)))
    want = light(portrait(), pix_fmt="yuv444p", full_range=True)
    assert got.strength == pytest.approx(want.strength, rel=0.02)
    in_srgb = np.linalg.solve(from_srgb_primaries(9), got.colour)
    np.testing.assert_allclose(in_srgb, want.colour, atol=0.03)


@pytest.mark.parametrize("pix_fmt", ["gray", "yuv420p"])
def test_a_video_without_colour_stands_in_white_light(pix_fmt):
    grey = np.repeat(cv2.cvtColor(portrait(), cv2.COLOR_RGB2GRAY)[..., None], 3, axis=2)
    estimate = light(grey, pix_fmt=pix_fmt, full_range=True)
    assert_sane(estimate)
    assert np.abs(estimate.colour - 1).max() < 0.02
    assert estimate.strength == pytest.approx(light(portrait()).strength, rel=0.25)


def test_a_warm_lamp_stays_warm_where_red_is_clipped():
    warmths = [warmth(light(lit(red, 1, 0.5))) for red in (1, 1.3, 1.8, 2.5, 3.5)]
    assert np.diff(warmths).min() > -0.02 and warmths[-1] > 0.4


@settings(max_examples=15, deadline=None)
@given(gain=CAST)
def test_any_cast_and_exposure_gives_a_sane_light(gain):
    assert_sane(light(lit(*gain)))


@settings(max_examples=25, deadline=None)
@given(
    size=st.tuples(st.integers(1, 40), st.integers(1, 40)),
    scale=st.floats(0.001, 3),
    shift=st.tuples(st.floats(-800, 800), st.floats(-800, 800)),
    kind=st.sampled_from(["black", "white", "noise"]),
    pix_fmt=st.sampled_from(["yuv420p", "nv12", "yuv444p10le", "gray"]),
)
def test_any_face_on_any_small_picture_gives_a_sane_light(size, scale, shift, kind, pix_fmt):
    w, h = size
    level = {"black": 0, "white": 255}.get(kind)
    noise = np.random.default_rng(w * 41 + h).integers(0, 256, (h, w, 3))
    rgb8 = (noise if level is None else np.full((h, w, 3), level)).astype(np.uint8)
    moved = points() * scale + [*shift, 0]
    item = FrameFaces(frame_of(rgb8, pix_fmt=pix_fmt), (face_at(moved),))
    assert_sane(light_of(item)[0])


@pytest.mark.parametrize("level", [0, 255])
def test_black_and_blown_out_faces_give_colourless_light(level):
    estimate = light(np.full_like(portrait(), level))
    assert_sane(estimate)
    assert np.abs(estimate.colour - 1).max() < 0.1


def test_points_that_are_not_finite_do_no_harm():
    broken = points().copy()
    broken[SKIN_POINTS[::3]] = np.nan
    deep = points().copy()
    deep[:, 2] = np.inf
    flat = points() * [0, 0, 0] + [200, 200, 0]
    for face in map(face_at, (broken, deep, flat, points() * np.nan)):
        assert_sane(light_of(FrameFaces(frame_of(portrait()), (face,)))[0])


def shaded(towards, rgb8=(200, 150, 130)):
    """Return a picture of the portrait's face as a matte mask, lit by a lamp in this direction."""
    face = points().astype(np.float64)
    a, b, c = face[TRIANGLES].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    picture = np.full_like(portrait(), 90)
    for point in SKIN_POINTS:
        normal = normals[(point == TRIANGLES).any(1)].mean(0)
        normal /= np.linalg.norm(normal)
        linear = to_linear(np.array(rgb8) / 255, SRGB) * (0.25 + 0.75 * max(normal @ towards, 0))
        x, y = np.rint(face[point, :2]).astype(int)
        picture[y - 1 : y + 2, x - 1 : x + 2] = np.rint(to_encoded(linear, SRGB) * 255)
    return picture


@pytest.mark.parametrize(
    "towards",
    [(-0.7, -0.3, -0.65), (0.7, -0.3, -0.65), (0, -0.8, -0.6), (0, 0, -1), (0.5, 0.4, -0.77)],
)  # fmt: skip
def test_shading_shows_where_the_light_comes_from(towards):
    towards = np.array(towards) / np.linalg.norm(towards)
    estimate = light(shaded(towards), pix_fmt="yuv444p")
    assert_sane(estimate)
    assert estimate.direction @ towards > 0.9


def test_even_light_counts_as_light_from_the_front_and_above():
    even = np.full_like(portrait(), 150)
    x, y, z = light(even).direction
    assert abs(x) < 0.1 and y < -0.15 and z < -0.7


@pytest.mark.parametrize("rotation_degrees", [90, 180, 270])
def test_the_light_turns_with_a_turned_picture(rotation_degrees):
    towards = np.array([-0.6, -0.5, -0.62])
    upright = light(shaded(towards), pix_fmt="yuv444p")
    frame = frame_of(shaded(towards), pix_fmt="yuv444p", rotation_degrees=rotation_degrees)
    to_stored = FramePicture(frame).to_stored
    turned = points().copy()
    turned[:, :2] = points()[:, :2] @ to_stored[:, :2].T + to_stored[:, 2]
    (estimate,) = light_of(FrameFaces(frame, (face_at(turned),)))
    want = np.append(to_stored[:, :2] @ upright.direction[:2], upright.direction[2])
    np.testing.assert_allclose(estimate.direction, want, atol=0.02)
    assert estimate.strength == pytest.approx(upright.strength, rel=0.02)
