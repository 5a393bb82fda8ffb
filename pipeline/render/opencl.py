"""The OpenCL device that paints; its failures become errors of this product."""

import os
from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import cache, wraps
from typing import TYPE_CHECKING, Any, TypeVar, TypeVarTuple

from makeup_video.pipeline.errors import InstallError, OutputError, UsageError, option

if TYPE_CHECKING:
    from makeup_video.kernels.program import Device

Args = TypeVarTuple("Args")
Made = TypeVar("Made")


def open_device(choice: str = "") -> "Device":
    """The OpenCL device with this number, counted from 0, or with this text in its name.

    "" is the processor, by PoCL.  Raises InstallError when there is no device at all, UsageError
    when none has that number or name, OutputError when no folder has room for compiled kernels.
    """
    with _errors_of_the_product():
        from makeup_video.kernels.program import Device

        Device.on_compile = _say_compiling
        return Device(choice)


def once_a_process(make: Callable[[*Args], Made]) -> Callable[[*Args], Made]:
    """Cache what `make` builds with OpenCL, by its arguments.

    A forked process cannot use its parent's OpenCL objects, so it makes its own.
    """

    @cache
    def made_in(_process_id: int, *args: Any) -> Made:
        return make(*args)

    @wraps(make, updated=())  # a function takes over no attributes of a class
    def made(*args: *Args) -> Made:
        return made_in(os.getpid(), *args)

    return made


@contextmanager
def _errors_of_the_product() -> Generator[None, None, None]:
    """Raise errors of OpenCL devices in the block as errors of this product."""
    # PyOpenCL takes a quarter of a second to load: runs that only copy or inspect do not load it
    from makeup_video.kernels.cache import NoRoomError
    from makeup_video.kernels.devices import NoDeviceError, UnknownDeviceError

    try:
        yield
    except NoDeviceError as error:
        raise InstallError(str(error)) from error
    except UnknownDeviceError as error:
        raise UsageError(f"{option('device')}: {error}") from error
    except NoRoomError as error:
        raise OutputError(str(error)) from error


_listeners: list[Callable[[], None]] = []


@contextmanager
def when_compiling(say: Callable[[], None]) -> Generator[None, None, None]:
    """Call `say` when this process begins to compile kernels in the block, which takes seconds.

    `say` is called at most once, by whichever thread compiles.
    """
    _listeners.append(say)
    try:
        yield
    finally:
        if say in _listeners:
            _listeners.remove(say)


def _say_compiling() -> None:
    while _listeners:
        _listeners.pop()()


def lost_kernels() -> str | None:
    """Settle where this process, and the processes that it starts, keep compiled kernels.

    Returns a line for the user where that folder is temporary and the next run has to compile the
    kernels again, else None.
    """
    from makeup_video.kernels.cache import NoRoomError, settle, why_not_kept

    try:
        settle()
    except NoRoomError:
        return None  # opening the device raises an error
    reason = why_not_kept()
    if reason is None:
        return None
    return (
        f"the compiled kernels cannot be kept ({reason}): set POCL_CACHE_DIR to a folder that stays"
    )


def opencl_devices() -> list[str]:
    """The names of this machine's OpenCL devices, in the order of their numbers.

    Raises as open_device does.
    """
    with _errors_of_the_product():
        from makeup_video.kernels.devices import devices

        return [f"{one.name.strip()} ({one.platform.name}, {one.version})" for one in devices()]
