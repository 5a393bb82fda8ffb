"""The OpenCL device, and the product's own errors when no device can be opened."""

import os
from unittest.mock import Mock

import pyopencl as cl
import pytest
from makeup_video.kernels import cache, devices
from makeup_video.kernels.cache import NoRoomError
from makeup_video.pipeline import InstallError, OutputError, UsageError
from makeup_video.pipeline.render.opencl import lost_kernels, once_a_process, open_device


def test_the_default_device_is_the_processor():
    assert open_device().shares_memory  # it works in ours


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

    monkeypatch.setattr(devices, "settle", no_room)
    with pytest.raises(OutputError, match="need a folder with room"):
        open_device()


def test_a_forked_process_makes_its_own_kernels(monkeypatch):
    make = once_a_process(lambda *args: (object(), *args))
    assert make() is make() and make("cpu") is make("cpu") and make("cpu")[1:] == ("cpu",)
    before = make()
    monkeypatch.setattr(os, "getpid", lambda: -1)
    assert make() is not before and make() is make()


def test_kernels_that_are_lost_are_one_line_with_the_remedy(monkeypatch, tmp_path):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    assert lost_kernels() is None
    (tmp_path / "file").touch()
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path / "file" / "below"))
    assert lost_kernels() == (
        f"the compiled kernels cannot be kept ({tmp_path}/file/below: Not a directory): set "
        "POCL_CACHE_DIR to a folder that stays"
    )
    monkeypatch.setattr(cache, "settle", Mock(side_effect=NoRoomError("none")))
    assert lost_kernels() is None  # opening the device says so
