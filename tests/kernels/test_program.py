"""Programs are built once; kernels work on memory."""

import os
import signal
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pyopencl as cl
import pytest
from kernel_arguments import on_device
from makeup_video.kernels import program
from makeup_video.kernels.definitions import Definitions
from makeup_video.kernels.devices import NoDeviceError
from makeup_video.kernels.program import Device, make_kernel

SOURCE = """
__kernel void test_add(__global uchar *restrict plane, const int stride, const int width) {
    int x = get_global_id(0);
    if (x >= width) return;
    plane[get_global_id(1) * stride + x] += 1;
}
"""

BYTES = np.dtype(np.uint8)
NOTHING = Definitions()


@pytest.fixture
def device(monkeypatch):
    monkeypatch.setattr(program, "source_of", {"test_add.cl": SOURCE}.__getitem__)
    return Device()


@pytest.mark.parametrize(("kind", "name"), [("kernel", "test_add"), ("program", "test_add.cl")])
def test_kernels_and_programs_are_built_once(device, kind, name):
    get = getattr(device, kind)
    first = get(name, 13, BYTES, NOTHING)
    assert get(name, 13, np.dtype(np.uint8), NOTHING) is first
    assert get(name, 16, BYTES, NOTHING) is not first
    assert get(name, 13, np.dtype(np.uint16), NOTHING) is not first
    assert kind == "kernel" or get(name, 13, BYTES, NOTHING, (2, 1)) is not first


@pytest.mark.parametrize("shares", [True, False])
def test_device_memory_shows_what_kernels_wrote(device, shares):
    device.shares_memory = shares
    memory = device.memory((3, 7), np.uint8)
    assert memory.array.shape == (3, 7) and memory.array.ctypes.data % 4096 == 0
    kernel = device.kernel("test_add", 13, BYTES, NOTHING)
    kernel.set_args(memory.buffer, np.int32(0), np.int32(21))
    for value in (5, 8):
        memory.array[:] = value
        memory.send()
        device.launch(kernel, (21, 1))
        memory.fetch()
        device.finish()
        assert (memory.array == value + 1).all()


@pytest.mark.parametrize("size", [(1, 1), (7, 5), (33, 17), (64, 3), (200, 2)])
def test_a_launch_reaches_every_work_item_and_no_more(device, size):
    width, height = size
    whole = np.arange((height + 4) * (width + 9)).astype(np.uint8).reshape(height + 4, width + 9)
    want = whole.copy()
    want[:height, :width] += 1
    with on_device(device, whole) as buffers:
        kernel = device.kernel("test_add", 13, BYTES, NOTHING)
        device.launch(kernel, size, [*buffers, np.int32(width + 9), np.int32(width)])
    np.testing.assert_array_equal(whole, want)


def test_sources_hold_their_includes_and_keep_other_text():
    text = program.source_of("colour.h")
    assert "colour_decode" in text
    text = 'int a;\n#include "b.h"\nint c;'
    assert program._INCLUDE.sub(r"[\1]", text) == "int a;\n[b.h]\nint c;"


def test_a_program_has_the_sample_type_of_its_planes():
    device = Device()
    source = "__kernel void size(__global int *out) { *out = sizeof(SAMPLE); }"
    for dtype in (np.uint8, np.uint16):
        out = np.zeros(1, np.int32)
        with on_device(device, out) as buffers:
            kernel = cl.Kernel(device.build(source, 13, np.dtype(dtype)), "size")
            device.launch(kernel, (1, 1), buffers)
        assert out[0] == np.dtype(dtype).itemsize


def test_without_a_linker_an_error_comes_before_pocl_aborts(monkeypatch, tmp_path):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(NoDeviceError, match="there is no ld on the PATH"):
        Device()
    compiled = tmp_path / "AB/CD/paint/8-1-1"
    compiled.mkdir(parents=True)
    (compiled / "paint.so").touch()
    Device()  # nothing is left to compile


def test_a_build_disturbed_by_ctrl_c_is_tried_once_more(monkeypatch):
    device, built = Device(), []
    build = cl.Program.build

    def disturbed(self, *words, **options):
        built.append(1)
        if len(built) == 1:
            raise cl.RuntimeError("clBuildProgram failed: BUILD_PROGRAM_FAILURE")
        return build(self, *words, **options)

    monkeypatch.setattr(cl.Program, "build", disturbed)
    assert device.build("__kernel void nothing() {}", 13) is not None
    assert len(built) == 2
    with pytest.raises(cl.RuntimeError):
        device.build("no C at all", 13)


def test_two_threads_never_make_kernels_at_once(monkeypatch):
    inside = []

    class Slow:
        def __init__(self, *_):
            inside.append(self)
            time.sleep(0.05)
            assert inside == [self]
            inside.clear()

    monkeypatch.setattr(program.cl, "Kernel", Slow)
    with ThreadPoolExecutor(4) as threads:
        made = list(threads.map(lambda _: make_kernel(None, "x"), range(8)))
    assert len(made) == 8


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_forked_process_does_not_wait_for_another_thread(monkeypatch):
    monkeypatch.setattr(program.cl, "Kernel", lambda *_: "made")
    with program._one_kernel:
        if (child := os.fork()) == 0:
            signal.alarm(20)  # ends the child if it waits
            os._exit(0 if make_kernel(None, "x") == "made" else 1)
    assert os.waitpid(child, 0)[1] == 0
