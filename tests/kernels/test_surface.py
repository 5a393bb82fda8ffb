"""The surfaces of lips and lids from the kernel against their numpy definition."""

import re
from fractions import Fraction
from importlib import resources

import av
import heads
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import LAYOUTS, close_up, lit_of, true_face
from makeup_video import kernels
from makeup_video.kernels.colour import HLG, PQ, Coding
from makeup_video.kernels.light import LightPlanes
from makeup_video.kernels.program import Device
from makeup_video.kernels.surface import (
    GIVEN,
    LID_SIGMA_PX,
    LIPS_SIGMA_PX,
    PATCH_HW,
    SEAM_SIGMA_PX,
    GridPlace,
    SurfaceKernel,
)
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.frames.affine import compose
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame, coding_of
from makeup_video.pipeline.render import build_scene
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.luminance_twin import luminances
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces, light_on_lid
from makeup_video.pipeline.render.surfaces.lips_twin import light_on_lips, lips_surface
from people import frame_of

SHUT, OPEN, BLINK = 60, 100, 75  # frames of the sample


def made_and_meant(frame: Frame, face: Face):
    """For each lit region: surface, shading and mean from the kernel, then the same from numpy.
    The lips come first."""
    (scene,) = BuildScene()(FrameFaces(frame, (face,))).faces
    by_kernel = lit_of(scene)
    lips = lips_surface(face)
    by_numpy = [*([] if lips is None else [lips]), *lid_surfaces(face)]
    light = luminances(frame, coding_of(frame), [region.grid for region in by_numpy])
    assert len(by_kernel) == len(by_numpy)
    for lit, region, luminance in zip(by_kernel, by_numpy, light, strict=True):
        light_on = light_on_lips if region is lips else light_on_lid
        yield lit.surface, lit.shading, lit.mean, region, *light_on(region, luminance)


def assert_same_surface(by_kernel, by_numpy):
    np.testing.assert_allclose(by_kernel.grid.to_px, by_numpy.grid.to_px, atol=1e-9)
    # float32 against float64 on steep contours; odds reach 200
    names = ("odds", "rim", "upper") if hasattr(by_numpy, "odds") else ("up", "lash_px", "below_px")
    for name in names:
        np.testing.assert_allclose(
            getattr(by_kernel, name), getattr(by_numpy, name), rtol=1e-4, atol=2e-3
        )
    np.testing.assert_allclose(by_kernel.normals, by_numpy.normals, atol=2e-3)


def turned(points_px, degrees, scale, to_xy):
    """The points turned about the middle of the close-up, scaled and moved."""
    angle = np.radians(degrees)
    spin = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    shift = np.array([100, 110]) + to_xy - spin @ (100, 110)
    return points_px @ spin.T + shift, np.column_stack([spin, shift])


@settings(max_examples=40, deadline=None)
@given(
    st.floats(-180, 180), st.floats(0.3, 3), st.tuples(*[st.floats(-60, 60)] * 2),
    st.sampled_from((SHUT, OPEN, BLINK)), st.floats(-0.5, 0.5),
    st.sampled_from((1.0, 0.5, 0.9, 4 / 3, 2.0)),
)  # fmt: skip
def test_surfaces_are_those_of_numpy(degrees, scale, to_xy, number, lean, pixel_aspect):
    rgb8, points = close_up(number)
    face = true_face(points)
    turned_px, spin = turned(points, degrees, scale, to_xy)
    squeeze = np.array([[1 / pixel_aspect, 0, 0], [0, 1, 0]])
    turned_px, spin = turned_px * (1 / pixel_aspect, 1), compose(squeeze, spin)
    depth = lean * turned_px[:, 0] + 0.3 * np.abs(turned_px[:, 0] - turned_px[:, 0].mean())
    face = heads.face(
        np.column_stack([turned_px, depth]),
        logits=face.lips.logits,
        to_px=compose(spin, face.lips.to_px),
    )
    for by_kernel, shading, mean, by_numpy, want_shading, want_mean in made_and_meant(
        frame_of(rgb8), face
    ):
        assert_same_surface(by_kernel, by_numpy)
        # the kernel reads chroma in blocks of four
        assert mean == pytest.approx(want_mean, rel=0.03, abs=3e-3)
        np.testing.assert_allclose(shading, want_shading, rtol=0.06, atol=0.01)


@pytest.mark.parametrize("pix_fmt", [*LAYOUTS, "gray"])
@pytest.mark.parametrize("scale", [1, 4])
def test_every_layout_gives_the_light_of_numpy(pix_fmt, scale):
    rgb8, points = close_up(OPEN)
    large = rgb8.repeat(scale, 0).repeat(scale, 1)
    face = heads.face((points + 0.5) * scale - 0.5)
    for _, shading, mean, _, want, want_mean in made_and_meant(
        frame_of(large, pix_fmt=pix_fmt), face
    ):
        assert mean == pytest.approx(want_mean, rel=0.02)
        np.testing.assert_allclose(shading, want, rtol=0.05, atol=5e-3)


@pytest.mark.parametrize("transfer", [PQ, HLG])
def test_hdr_has_the_light_of_numpy(transfer):
    _, points = close_up(OPEN)
    picture = av.VideoFrame(200, 220, "yuv420p10le")
    frame = Frame(picture, 0, Fraction(1, 30), ColourTags(9, 1, transfer, 9))
    for plane, code in zip(frame.writable_planes(), (500, 480, 560), strict=True):
        plane[:] = np.linspace(code - 40, code + 40, plane.shape[1]).astype(np.uint16)
    for _, shading, mean, _, want, want_mean in made_and_meant(frame, heads.face(points)):
        assert mean == pytest.approx(want_mean, rel=0.02)
        np.testing.assert_allclose(shading, want, rtol=0.05, atol=5e-3)


@pytest.mark.parametrize("size_wh", [(1, 1), (2, 1), (3, 5), (16, 16)])
@pytest.mark.parametrize("pix_fmt", ["yuv420p", "nv12", "yuv444p10le", "gray"])
def test_frames_smaller_than_a_face_give_finite_surfaces(size_wh, pix_fmt):
    rgb8 = np.full((*size_wh[::-1], 3), 140, np.uint8)
    _, points = close_up()
    for points_px in (points, points - 5000, points + 1e6):
        (scene,) = BuildScene()(
            FrameFaces(frame_of(rgb8, pix_fmt=pix_fmt), (heads.face(points_px),))
        ).faces
        for lit in lit_of(scene):
            assert np.isfinite(lit.shading).all() and np.ptp(lit.shading) < 1e-3
            assert lit.mean == pytest.approx(0.27, abs=0.03)


@pytest.mark.parametrize("shape", [SHUT, OPEN])
def test_highlights_leave_out_the_furrow_between_the_lips(shape):
    rgb8, points = close_up(shape)
    (scene,) = BuildScene()(FrameFaces(frame_of(rgb8), (heads.face(points),))).faces
    lips = lit_of(scene)[0].surface
    exposed, upper = lips.normals[2], lips.upper
    assert exposed.min() >= 0 and exposed.max() <= 1
    assert (exposed[(upper > 0) & (upper < 1)] == 0).all()
    both_sides = exposed[:, exposed.shape[1] // 2]
    assert both_sides[0] == both_sides[-1] == 1 and (both_sides == 0).any()


@pytest.mark.parametrize("squeezed", [(0.2, 1, 1), (0, 1, 1), (0, 0, 0), (1, 1, 1e6)])
def test_degenerate_faces_have_finite_surfaces(squeezed):
    rgb8, points = close_up(OPEN)
    points = np.column_stack([points, points[:, 0]]) * squeezed + (20, 20, 0)
    face = heads.face(points, to_px=heads.face(points + 0.0).lips.to_px + np.eye(2, 3))
    (scene,) = BuildScene()(FrameFaces(frame_of(rgb8), (face,))).faces
    for lit in lit_of(scene):
        assert np.isfinite(lit.surface.normals).all() and np.isfinite(lit.shading).all()
        assert (np.square(lit.surface.normals[:2]).sum(0) < 1.0001).all()


@pytest.mark.parametrize(
    ("name", "sigma"),
    [("lip", LIPS_SIGMA_PX), ("lid", LID_SIGMA_PX), ("seam", SEAM_SIGMA_PX)],
)
def test_taps_are_gaussians_of_the_twins_sigmas(name, sigma):
    text = (resources.files(kernels) / "surface.h").read_text(encoding="utf-8")
    listed = re.search(rf"surface_{name}_taps\[\d+\] = \{{(.*?)\}};", text, re.DOTALL)[1]
    taps = np.array([float(number.strip(" \nf")) for number in listed.split(",")])
    places = np.arange(-len(taps) + 1, len(taps))
    bell = np.exp(-(places**2) / (2 * sigma**2))
    np.testing.assert_allclose(taps, bell[len(taps) - 1 :] / bell.sum(), rtol=2e-7)
    assert len(taps) == round(4 * sigma) + 1


def test_a_device_with_its_own_memory_makes_the_same(monkeypatch):
    rgb8, points = close_up(OPEN)
    item = FrameFaces(frame_of(rgb8), (true_face(points),))
    made = []
    for shares in (True, False):
        device = Device()
        device.shares_memory = shares
        monkeypatch.setattr(build_scene, "open_device", lambda _, device=device: device)
        (scene,) = BuildScene(exclusive=True)(item).faces
        made.append(lit_of(scene))
    for one, other in zip(*made, strict=True):
        np.testing.assert_array_equal(one.shading, other.shading)
        np.testing.assert_array_equal(one.surface.normals, other.surface.normals)
        assert one.shading.any() and one.mean == other.mean


def test_the_head_of_given_lies_as_its_layout_names_it():
    light = LightPlanes(
        (np.zeros((6, 8), np.uint8), *[np.zeros((3, 5), np.uint8)] * 2),
        (1.0, 0.5, 2.0, 0.25), (0.5, 0.125, 1.0, 0.0625), Coding(),
    )  # fmt: skip
    place = GridPlace((2.0, 0.0, 10.0, 0.0, 2.0, 20.0), (0.5, 0.0, 10.25, 0.0, 0.5, 20.0))
    kernel = SurfaceKernel(Device(), np.zeros((18, 11)))
    points = np.arange(3.0 * 478).reshape(478, 3)
    kernel._fill([None, place, None], points, np.ones(PATCH_HW), light)
    (head,) = kernel._given.view(GIVEN)
    np.testing.assert_array_equal(head["points"], points)
    assert not head["logits"].any() and not head["places"]["to_own"][[0, 2]].any()
    assert head["luma"]["row_step"] == 8 and head["chroma"]["last_x"] == pytest.approx(4, rel=1e-5)
    lid = head["places"][1]
    assert (lid["own_px"], lid["step_px"]) == (2, 0.5)
    np.testing.assert_array_equal(lid["to_own"], 2 * np.eye(2))
    np.testing.assert_array_equal(lid["near"] + 0.5 * -lid["origin"], (10.25, 20))
    np.testing.assert_array_equal(lid["to_chroma"], [[1, 0, 5.125], [0, 2, 20.0625]])
    np.testing.assert_allclose(head["weights"].sum(), 1, rtol=1e-6)
    assert head["last_step"] == 1023
