"""An OpenCL device, the kernels of the package built for it, and memory that they work on.

Only one thread at a time may use a Device: OpenCL keeps a kernel's arguments in the kernel.
"""

import math
import os
import re
import threading
import weakref
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from importlib import resources
from typing import Any, ClassVar, TypeVar

import numpy as np
import pyopencl as cl
from makeup_video.kernels.binaries import binary_file, load_binary, save_binary
from makeup_video.kernels.cache import can_compile, restore
from makeup_video.kernels.definitions import Definitions
from makeup_video.kernels.devices import POCL, NoDeviceError, pick

# PoCL compiles a kernel again for every local size, so all launches of a kernel use one.
LOCAL_SIZE = (16, 1)
_SAMPLES = {np.dtype(np.uint8): "uchar", np.dtype(np.uint16): "ushort"}
_PAGE = 4096  # bytes
_INCLUDE = re.compile(r'^#include "(\w+\.h)"$', re.MULTILINE)
_NO_DEFINITIONS = Definitions()
_Made = TypeVar("_Made")


def source_of(name: str) -> str:
    """Read a file of this package with its includes in place, so that none is needed on disk."""
    text = (resources.files(__package__) / name).read_text(encoding="utf-8")
    return _INCLUDE.sub(lambda match: source_of(match[1]), text)


def make_kernel(program: Any, name: str) -> Any:
    """Make a kernel of a program, in one thread at a time.

    PyOpenCL generates Python for a kernel, under a name that it first checks to be free. Two
    threads would take the same name, and Python would warn.
    """
    with _one_kernel:
        return cl.Kernel(program, name)


def _renew_lock() -> None:
    global _one_kernel
    _one_kernel = threading.Lock()


_one_kernel = threading.Lock()
if hasattr(os, "register_at_fork"):  # another thread may hold the lock when a process is forked
    os.register_at_fork(after_in_child=_renew_lock)


class Device:
    """An OpenCL device and its queue. Programs and kernels are built at first use and kept.

    watch: for measurements: (device, work-items) -> a context in which each launch runs; or None.
    on_compile: called before compiling a program that no process has compiled before; or None.
    """

    on_compile: ClassVar[Callable[[], None] | None] = None
    _has_saved: ClassVar[bool] = False  # True when this process has saved a program for later ones
    watch: "ClassVar[Callable[[Device, int], AbstractContextManager[None]] | None]" = None

    def __init__(self, choice: str = "") -> None:
        """choice: as for pick. Raises NoDeviceError, NoRoomError, UnknownDeviceError."""
        device = pick(choice)
        if device.platform.name == POCL and not can_compile():
            raise NoDeviceError(
                "PoCL compiles the kernels that paint with the system's linker, and there is no ld "
                "on the PATH: install it (Debian, Ubuntu: apt install gcc)"
            )
        self.context = cl.Context([device])
        self.queue = cl.CommandQueue(self.context)
        # A CPU works in our memory; other devices may work in a copy.
        self.shares_memory = bool(device.type & cl.device_type.CPU)
        self._made: dict[Any, Any] = {}
        self._kernels: dict[tuple[str, int, np.dtype], Any] = {}
        self._programs: dict[tuple[str, int, np.dtype, tuple[int, int], Definitions], Any] = {}

    def once(self, make: "Callable[[Device], _Made]") -> _Made:
        """Return what `make` makes of this device: made at the first call with `make`, and kept.

        The result refers to the device weakly: otherwise both would wait for the garbage collector.
        """
        if make not in self._made:
            self._made[make] = make(weakref.proxy(self))
        made: _Made = self._made[make]
        return made

    def kernel(self, name: str, transfer: int, sample: np.dtype, definitions: Definitions) -> Any:
        """Return the kernel `name` of `name`.cl, for one transfer function and sample dtype.

        transfer: ITU-T H.273, 13, 16 or 18.  sample: uint8 or uint16.  definitions: those of the
        file, the same at every call.
        """
        key = name, transfer, sample
        if key not in self._kernels:
            program = self.program(f"{name}.cl", transfer, sample, definitions)
            self._kernels[key] = make_kernel(program, name)
        return self._kernels[key]

    def program(
        self,
        file: str,
        transfer: int,
        sample: np.dtype,
        definitions: Definitions,
        block: tuple[int, int] = (1, 1),
    ) -> Any:
        """Return the program of a file of this package.

        transfer, sample: as for `kernel`.
        definitions: those of the file, or of a variant of it; the same object at every call.
        block: luma pixels of a chroma sample, across and down.
        """
        key = file, transfer, sample, block, definitions
        if key not in self._programs:
            spelled = _spelled(source_of(file), transfer, sample, block, definitions)
            self._programs[key] = self._kept(*spelled)
        return self._programs[key]

    def build(
        self,
        source: str,
        transfer: int,
        sample: np.dtype | None = None,
        block: tuple[int, int] = (1, 1),
        definitions: Definitions = _NO_DEFINITIONS,
    ) -> Any:
        """Build a program from any source.

        PoCL keeps the compiled program on disk for the next process, by source and options.
        sample: what SAMPLE stands for; None for a source without SAMPLE.  block: BLOCK_ACROSS and
        BLOCK_DOWN.
        """
        return self._compiled(*_spelled(source, transfer, sample, block, definitions))

    def _kept(self, source: str, options: list[str]) -> Any:
        """The program that an earlier process has saved, or a new one, which may be saved."""
        (device,) = self.context.devices
        if device.platform.name != POCL:
            return self._compiled(source, options)
        file = binary_file(device, source, options)
        program = load_binary(self.context, file)
        if program is None:
            if Device.on_compile is not None and not file.exists():
                Device.on_compile()
            program = self._compiled(source, options)
            # Saving all programs takes as long as building them at first: a process saves only one.
            if not Device._has_saved or not file.exists():
                Device._has_saved |= save_binary(program, file)
        return program

    def _compiled(self, source: str, options: list[str]) -> Any:
        try:
            return cl.Program(self.context, source).build(options=options)
        except cl.RuntimeError:
            # At Ctrl-C LLVM deletes its temporary files and then fails without them, while our run
            # still has to end in good order. Or somebody removed the folder of the kernels.
            restore()
            return cl.Program(self.context, source).build(options=options)

    def memory(self, shape: tuple[int, ...], dtype: Any) -> "Memory":
        """Make an array that kernels work on."""
        return Memory(self, shape, np.dtype(dtype))

    def finish(self) -> None:
        """Wait for all kernels that were started."""
        self.queue.finish()

    def launch(
        self,
        kernel: Any,
        size_wh: tuple[int, int],
        arguments: Sequence[Any] = (),
        local_wh: tuple[int, int] = LOCAL_SIZE,
    ) -> None:
        """Start a kernel over size_wh work-items, rounded up to whole groups across.

        The kernel itself must skip the work-items beyond the right edge.
        arguments: empty when the kernel already has them.  local_wh: the size of a work-group;
        size_wh must be whole groups down.
        """
        if arguments:
            kernel.set_args(*arguments)
        width = -(-size_wh[0] // local_wh[0]) * local_wh[0]
        if Device.watch is None:
            cl.enqueue_nd_range_kernel(self.queue, kernel, (width, size_wh[1]), local_wh)
            return
        with Device.watch(self, size_wh[0] * size_wh[1]):
            cl.enqueue_nd_range_kernel(self.queue, kernel, (width, size_wh[1]), local_wh)


def _spelled(
    source: str,
    transfer: int,
    sample: np.dtype | None,
    block: tuple[int, int],
    definitions: Definitions,
) -> tuple[str, list[str]]:
    """The whole source of a program, and the compiler's options."""
    options = [f"-DCOLOUR_TRANSFER={transfer}", *definitions.options()]
    if sample is not None:
        options += [
            f"-DSAMPLE={_SAMPLES[sample]}",
            f"-DBLOCK_ACROSS={block[0]}",
            f"-DBLOCK_DOWN={block[1]}",
        ]
    return definitions.source() + source, options


class Memory:
    """An array that kernels work on, or a copy of it where the device has memory of its own.

    array: C order, uninitialised, aligned to a page (some devices share only whole pages).
    buffer: the kernel argument.
    """

    def __init__(self, device: Device, shape: tuple[int, ...], dtype: np.dtype) -> None:
        count = math.prod(shape) * dtype.itemsize
        room = np.empty(count + _PAGE, np.uint8)
        first = -room.ctypes.data % _PAGE
        self.array = room[first : first + count].view(dtype).reshape(shape)
        self._queue = None if device.shares_memory else device.queue
        if device.shares_memory:
            flags = cl.mem_flags.READ_WRITE | cl.mem_flags.USE_HOST_PTR
            self.buffer = cl.Buffer(device.context, flags, hostbuf=self.array)
        else:
            self.buffer = cl.Buffer(device.context, cl.mem_flags.READ_WRITE, count)

    def send(self) -> None:
        """Copy the array to the device, for the kernels that start later."""
        if self._queue:
            cl.enqueue_copy(self._queue, self.buffer, self.array, is_blocking=False)

    def fetch(self) -> None:
        """Copy the result of the kernels started so far to the array, complete after `finish`."""
        if self._queue:
            cl.enqueue_copy(self._queue, self.array, self.buffer, is_blocking=False)
