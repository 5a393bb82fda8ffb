"""The OpenCL device that paints, with the errors of this product."""

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
    """The OpenCL device by its number, from 0, or by a part of its name; "" is the processor, by
    PoCL.

    Raises InstallError when there is none at all, UsageError when there is none of that name,
    OutputError when no folder has room for compiled kernels.
    """
    with _errors_of_the_product():
        from makeup_video.kernels.program import Device

        Device.on_compile = _say_compiling
        return Device(choice)


def once_a_process(make: Callable[[*Args], Made]) -> Callable[[*Args], Made]:
    """What `make` builds with OpenCL, cached by its arguments. A forked process, which cannot use
    its parent's, makes its own."""

    @cache
    def made_in(_process_id: int, *args: Any) -> Made:
        return make(*args)

    @wraps(make, updated=())  # attributes of a class are none of a function
    def made(*args: *Args) -> Made:
        return made_in(os.getpid(), *args)

    return made


@contextmanager
def _errors_of_the_product() -> Generator[None, None, None]:
    """Raise what goes wrong with devices in the block as errors of this product."""
    # PyOpenCL takes a quarter of a second to load: runs that only copy or inspect do without
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
    """Call `say` within the block once this process compiles kernels, which takes some seconds.

    Any thread may call it, at most once.
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
    """Settle where the kernels of this process, and of those that it starts, are kept.

    Returns a line for the user where the folder is temporary, so that the next run has to compile
    them again.
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
    """The OpenCL devices of this machine by their names, in the order of their numbers.

    Raises as open_device does.
    """
    with _errors_of_the_product():
        from makeup_video.kernels.devices import devices

        return [f"{one.name.strip()} ({one.platform.name}, {one.version})" for one in devices()]
