"""The OpenCL device that paints, with the errors of this product."""

from typing import TYPE_CHECKING

from makeup_video.pipeline.errors import InstallError, OutputError, UsageError, option

if TYPE_CHECKING:
    from makeup_video.kernels.program import Device


def open_device(choice: str = "") -> "Device":
    """The OpenCL device by its number, from 0, or by a part of its name; "" is the processor, by
    PoCL.

    Raises InstallError when there is none at all, UsageError when there is none of that name,
    OutputError when no folder has room for compiled kernels.
    """
    # PyOpenCL takes a quarter of a second to load: runs that only copy or inspect do without
    from makeup_video.kernels.cache import NoRoomError
    from makeup_video.kernels.program import Device, NoDeviceError, UnknownDeviceError

    try:
        return Device(choice)
    except NoDeviceError as error:
        raise InstallError(str(error)) from error
    except UnknownDeviceError as error:
        raise UsageError(f"{option('device')}: {error}") from error
    except NoRoomError as error:
        raise OutputError(str(error)) from error


def devices_found() -> list[str]:
    """The OpenCL devices of this machine by their names, in the order of their numbers.

    Raises as open_device does.
    """
    from makeup_video.kernels.cache import NoRoomError
    from makeup_video.kernels.program import NoDeviceError, devices

    try:
        return [f"{one.name.strip()} ({one.platform.name}, {one.version})" for one in devices()]
    except NoDeviceError as error:
        raise InstallError(str(error)) from error
    except NoRoomError as error:
        raise OutputError(str(error)) from error
