"""The OpenCL device, and the product's own errors when no device can be opened."""

import pyopencl as cl
import pytest
from makeup_video.kernels import program
from makeup_video.kernels.cache import NoRoomError
from makeup_video.pipeline import InstallError, OutputError, UsageError
from makeup_video.pipeline.render.opencl import open_device


def test_the_default_device_opens():
    assert open_device().queue is not None


def test_no_opencl_at_all_is_an_install_error(monkeypatch):
    monkeypatch.setattr(cl, "get_platforms", list)
    with pytest.raises(InstallError, match="pocl-binary-distribution"):
        open_device()


def test_an_unknown_device_is_a_usage_error():
    with pytest.raises(UsageError, match="no such device"):
        open_device("no such device")


def test_no_room_for_kernels_is_an_output_error(monkeypatch):
    def no_room():
        raise NoRoomError("the kernels need a folder with room")

    monkeypatch.setattr(program, "settle", no_room)
    with pytest.raises(OutputError, match="need a folder with room"):
        open_device()
