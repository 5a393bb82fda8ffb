"""The virtual camera, with a fake pyvirtualcam."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from makeup_video.pipeline import InstallError, OutputError
from makeup_video.pipeline.live.interfaces import LivePicture
from makeup_video.pipeline.live.sinks.virtual_camera import VirtualCamera
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera
from media import picture

RED = (180, 40, 90)
WEIGHTS = {1: (0.2126, 0.0722), 6: (0.299, 0.114), 9: (0.2627, 0.0593)}


def codes(rgb, matrix, full):
    """Y', Cb, Cr of an sRGB colour, by ITU-R BT.601, 709 and 2020."""
    red, green, blue = (value / 255 for value in rgb)
    kr, kb = WEIGHTS[matrix]
    luma = kr * red + (1 - kr - kb) * green + kb * blue
    cb, cr = (blue - luma) / (2 - 2 * kb), (red - luma) / (2 - 2 * kr)
    if full:
        return 255 * luma, 128 + 255 * cb, 128 + 255 * cr
    return 16 + 219 * luma, 128 + 224 * cb, 128 + 224 * cr


def shown(matrix=6, full=False, size_wh=(64, 48), degrees=0):
    source = picture(0, *size_wh)
    frame = NormaliseCamera(is_device=False)(source, 1.0)
    for plane, code in zip(frame.writable_planes(), codes(RED, matrix, full), strict=True):
        plane[:] = round(code)
    frame.tags = type(frame.tags)(matrix, 2 if full else 1)
    frame.picture.colorspace, frame.picture.color_range = matrix, 2 if full else 1
    frame.rotation_degrees = degrees
    return LivePicture(frame)


class FakeCamera:
    device = "/dev/video9"

    def __init__(self, width, height, fps, *, fmt, device):
        self.settings = (width, height, fps, fmt, device)
        self.sent, self.closed = [], False

    def send(self, codes):
        assert codes.dtype == np.uint8 and codes.flags.c_contiguous and codes.ndim == 1
        self.sent.append(codes.copy())

    def close(self):
        self.closed = True


@pytest.fixture
def library(monkeypatch):
    made = []

    def camera(*args, **kwargs):
        made.append(FakeCamera(*args, **kwargs))
        return made[-1]

    fake = SimpleNamespace(Camera=camera, PixelFormat=SimpleNamespace(I420="I420"), made=made)
    monkeypatch.setitem(sys.modules, "pyvirtualcam", fake)
    return fake


@pytest.mark.parametrize("matrix", WEIGHTS)
@pytest.mark.parametrize("full", [False, True])
def test_programs_get_limited_bt601_whatever_the_source_is(library, matrix, full):
    sink = VirtualCamera(rate=30)
    sink(shown(matrix, full))
    luma, cb, cr = np.split(library.made[0].sent[0], [64 * 48, 64 * 48 * 5 // 4])
    for got, want in zip((luma, cb, cr), codes(RED, 6, False), strict=True):
        assert np.abs(got.astype(float) - want).max() <= 2.5  # two roundings and FFmpeg's tables
    assert library.made[0].settings == (64, 48, 30.0, "I420", None)
    assert sink.name == "/dev/video9" and sink.sent == 1


def test_a_turned_picture_is_shown_upright(library):
    sink = VirtualCamera("/dev/video9")
    sink(shown(degrees=270))
    assert library.made[0].settings[:2] == (48, 64) and library.made[0].settings[4] == "/dev/video9"


def test_finish_closes_the_camera_if_a_picture_opened_one(library):
    sink = VirtualCamera()
    sink.finish()
    assert library.made == []
    sink(shown())
    sink.finish()
    assert library.made[0].closed


def test_a_missing_library_names_the_command_that_installs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvirtualcam", None)
    with pytest.raises(InstallError, match=r"pip install 'makeup-video\[virtualcam\]'"):
        VirtualCamera()


def test_a_missing_device_is_one_line_with_what_to_do(library):
    def none(*args, **kwargs):
        raise RuntimeError(
            "'v4l2loopback' backend: No v4l2 loopback device found.\nDid you load it?"
        )

    library.Camera = none
    with pytest.raises(OutputError, match="modprobe v4l2loopback") as caught:
        VirtualCamera()(shown())
    assert "\n" not in str(caught.value)


def test_a_device_that_goes_away_is_one_line_and_closed(library):
    sink = VirtualCamera()
    sink(shown())

    def gone(codes):
        raise RuntimeError("write failed")

    library.made[0].send = gone
    with pytest.raises(OutputError, match="no longer takes frames"):
        sink(shown())
    assert library.made[0].closed and sink.sent == 1


def test_a_missing_device_is_one_line_from_the_real_library():
    pytest.importorskip("pyvirtualcam")
    try:
        sink = VirtualCamera("/dev/video63")
        sink(shown())
    except OutputError as error:
        assert "\n" not in str(error) and "modprobe" in str(error)
    else:
        pytest.fail("/dev/video63 exists on this machine")
