"""The OpenCL devices of this machine, and the choice of one."""

import os
from typing import Any

import pyopencl as cl
from makeup_video.kernels.cache import left_clean, settle

POCL = "Portable Computing Language"
# The device that works in the caller's thread comes first: handing so little work to other threads
# costs more CPU time than the work itself, and the other core is busy. A user's own choice stays.
_POCL_DEVICES = "basic pthread"
# When one of these is set, OpenCL's loader looks for drivers there and nowhere else.
_LOADER = ("OCL_ICD_VENDORS", "OCL_ICD_FILENAMES", "OPENCL_VENDOR_PATH")


class NoDeviceError(RuntimeError):
    """This machine has no OpenCL device."""


class UnknownDeviceError(ValueError):
    """No OpenCL device has that name or number."""


def devices() -> list[Any]:
    """List every OpenCL device, PoCL's first. Raises NoDeviceError, NoRoomError."""
    folder = settle()
    given = os.environ.get("POCL_DEVICES")
    if given is None:
        os.environ["POCL_DEVICES"] = _POCL_DEVICES
    with left_clean(folder):
        found = _found()
        if given is None and not any(device.platform.name == POCL for device in found):
            del os.environ["POCL_DEVICES"]  # this PoCL has other names for its devices
            found = _found()
        if not found:
            raise NoDeviceError(_why_none(given))
    return found


def _why_none(pocl_devices: str | None) -> str:
    """Say what the user can do: unset a variable that hides the devices, else install a driver."""
    if pocl_devices is not None:
        del os.environ["POCL_DEVICES"]
        known = _found()
        os.environ["POCL_DEVICES"] = pocl_devices
        if known:
            return (
                f"POCL_DEVICES={pocl_devices!r} names a device that PoCL does not know: unset it, "
                f"or name devices that PoCL knows, such as {_POCL_DEVICES!r}"
            )
    set_by_user = [f"{name}={os.environ[name]!r}" for name in _LOADER if os.environ.get(name)]
    if set_by_user:
        return (
            "painting needs an OpenCL device, found none where the environment says to look "
            f"({', '.join(set_by_user)}): unset these variables"
        )
    return (
        "painting needs an OpenCL device, found none: pip install pocl-binary-distribution "
        "(Linux x86-64), or install your system's PoCL or the OpenCL driver of your GPU"
    )


def _found() -> list[Any]:
    try:
        platforms = cl.get_platforms()
    except cl.LogicError:  # the loader finds no platform
        return []
    platforms = sorted(platforms, key=lambda platform: platform.name != POCL)
    return [device for platform in platforms for device in _of(platform)]


def _of(platform: Any) -> list[Any]:
    try:
        return list(platform.get_devices())
    except cl.RuntimeError:  # a platform without devices
        return []


def pick(choice: str = "") -> Any:
    """Pick a device by its number, counted from 0, or by a part of its name; "" picks the first.

    Any other number must be a whole word of a name, such as 4090.

    Raises NoDeviceError, NoRoomError, UnknownDeviceError.
    """
    found = devices()
    numbered = {str(number): device for number, device in enumerate(found)}
    if choice in numbered:
        return numbered[choice]
    matching = [device for device in found if _is_named(device, choice.lower())]
    if not matching:
        known = ", ".join(f"{number} {device.name.strip()}" for number, device in enumerate(found))
        raise UnknownDeviceError(
            f"an OpenCL device is given by its number or a part of its name, got {choice!r}; "
            f"there is: {known}"
        )
    return matching[0]


def _is_named(device: Any, part: str) -> bool:
    name = f"{device.platform.name} {device.name}".lower()
    return part in (name.split() if part.isdecimal() else name)
