"""The surface of a face from the kernel against its numpy definition."""

import re
from dataclasses import replace
from fractions import Fraction
from importlib import resources

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lit_faces import face_at, lit, points, surface_made
from makeup import LAYOUTS
from makeup_video import kernels
from makeup_video.kernels.colour import HLG, PQ
from makeup_video.kernels.face import EDGE_PX, HOLE_PX, SIGMA_PX, FaceKernel
from makeup_video.kernels.program import Device
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame, coding_of
from makeup_video.pipeline.render.surfaces.face import FaceSurface, face_kernel, face_surface
from makeup_video.pipeline.render.surfaces.face_twin import face_surface_twin
from people import frame_of, portrait


def assert_same(face, frame):
    """Compare the surface and the light of the kernel with those of the twin."""
    surface, shading, mean = surface_made(face, frame)
    want, want_shading, want_mean = face_surface_twin(face, frame, coding_of(frame))
    for name in FaceSurface.READ[:5]:
        # float32 sums in another order
        np.testing.assert_allclose(getattr(surface, name), getattr(want, name), atol=1e-3)
    # OpenCV reads at steps of 1/32 px. And a place whose visibility is close to the threshold of a
    # sample may be a sample for one of the two only.
    off = np.abs(surface.likeness - want.likeness)
    assert np.mean(off) < 0.01 and np.quantile(off, 0.99) < 0.1
    seen = want.visible * want.likeness > 0.3
    np.testing.assert_allclose(shading[seen], want_shading[seen], rtol=0.05, atol=1e-4)
    assert mean == pytest.approx(want_mean, rel=0.02)


@pytest.mark.parametrize("pix_fmt", [*LAYOUTS, "gray"])
def test_every_layout_is_read_as_in_numpy(pix_fmt):
    assert_same(face_at(points()), frame_of(portrait(), pix_fmt=pix_fmt))


@pytest.mark.parametrize("transfer", [PQ, HLG])
def test_hdr_is_read_as_in_numpy(transfer):
    picture = frame_of(portrait(), pix_fmt="yuv420p10le").picture
    frame = Frame(picture, 0, Fraction(1, 30), ColourTags(9, 1, transfer, 9))
    assert_same(face_at(points()), frame)


def test_after_an_interrupted_build_nothing_old_is_used(monkeypatch):
    """A notebook's "stop" may come while a kernel is compiled."""
    frame = frame_of(portrait(), pix_fmt="yuv420p10le")
    dark = Frame(frame.picture, 0, Fraction(1, 30), ColourTags(9, 1, PQ, 9))
    surface_made(face_at(points()), frame)
    real, refused = Device.kernel, []

    def refuse_once(device, *words):
        if not refused:
            refused.append(words)
            raise KeyboardInterrupt
        return real(device, *words)

    monkeypatch.setattr(Device, "kernel", refuse_once)
    with pytest.raises(KeyboardInterrupt):
        surface_made(face_at(points()), dark)
    assert_same(face_at(points()), dark)
    assert_same(face_at(points()), frame)


@settings(max_examples=20, deadline=None)
@given(
    st.floats(0.1, 1.5), st.floats(-180, 180), st.floats(-0.4, 0.4), st.sampled_from([0.2, 1, 1.6])
)
def test_a_face_of_any_size_and_turn_is_as_in_numpy(size, degrees, yaw, gain):
    middle = points().mean(0)
    a, b = np.radians(degrees), yaw
    about_z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    turned = (points() - middle) @ (size * about_z @ about_y).T + middle
    assert_same(face_at(turned), frame_of(lit(gain, gain, gain)))


def test_a_hidden_mouth_leaves_the_cheeks_out():
    face = replace(face_at(points()), mouth_visible=0.0)
    assert_same(face, frame_of(portrait()))


def test_one_kernel_reads_planes_of_any_size_and_depth():
    device = Device()
    kernel = face_kernel(device)
    for size, pix_fmt in ((0.3, "yuv420p"), (1.5, "yuv444p"), (1.0, "yuv420p10le"), (0.3, "nv12")):
        face = face_at(points() * np.float32(size))
        frame, another = frame_of(portrait(), pix_fmt=pix_fmt), Device()
        fresh = face_surface(face, frame, coding_of(frame), face_kernel(another))
        again = face_surface(face, frame, coding_of(frame), kernel)
        np.testing.assert_array_equal(again[0].likeness, fresh[0].likeness)
        np.testing.assert_array_equal(again[1], fresh[1])


def test_what_was_made_stays_when_the_next_is_made():
    device, frame = Device(), frame_of(portrait())
    kernel = face_kernel(device)
    first, _, _ = face_surface(face_at(points()), frame, coding_of(frame), kernel)
    before = first.across.copy()
    face_surface(face_at(points() + 30), frame_of(lit(0.5, 0.5, 0.5)), coding_of(frame), kernel)
    np.testing.assert_array_equal(first.across, before)


def test_a_device_makes_the_kernel_once():
    device = Device()
    assert isinstance(face_kernel(device), FaceKernel)
    assert face_kernel(device) is face_kernel(device)


@pytest.mark.parametrize(
    ("name", "sigma"), [("face", SIGMA_PX), ("face_edge", EDGE_PX), ("face_hole", HOLE_PX)]
)
def test_taps_are_gaussians_of_the_twins_sigmas(name, sigma):
    text = (resources.files(kernels) / "face.cl").read_text(encoding="utf-8")
    listed = re.search(rf" {name}_taps\[\d+\] = \{{(.*?)\}};", text, re.DOTALL)[1]
    taps = np.array([float(number.strip(" \nf")) for number in listed.split(",")])
    places = np.arange(-len(taps) + 1, len(taps))
    bell = np.exp(-(places**2) / (2 * sigma**2))
    np.testing.assert_allclose(taps, bell[len(taps) - 1 :] / bell.sum(), rtol=2e-7)
