"""What `makeup-video doctor` checks: versions, memory, devices, encoders, a self-test."""

import platform
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from makeup_video.cli.outcome import error_text

_PACKAGES = (
    "av", "numpy", "opencv-contrib-python-headless", "onnxruntime", "pyopencl",
    "pocl-binary-distribution", "pillow", "pi-heif", "simplejpeg", "starlette", "uvicorn", "typer",
)  # fmt: skip
_EXTRAS = ("pyvirtualcam", "cryptography", "ray")
_LITTLE_BYTES = 1_000_000_000  # what painting 1080p takes, with some room
_REAL_TIME_FPS = 30
OK, NOTE, BAD = "ok", "note", "bad"


@dataclass(frozen=True, slots=True)
class Finding:
    """One line: the state, what was checked, and words that say what was found or what to do."""

    state: str
    what: str
    words: str


def findings(device: str) -> Iterator[Finding]:
    """Check one thing after the other.  device: the OpenCL device to test."""
    from makeup_video.pipeline.errors import MakeupVideoError

    yield Finding(OK, "makeup-video", _own_version())
    yield Finding(OK, "system", _system())
    yield _packages()
    checks: tuple[tuple[str, Callable[[], Finding]], ...] = (
        ("memory", _memory),
        ("OpenCL", _opencl),
        ("encoders", _encoders),
        ("HEIC photos", _heic),
        ("cameras", _cameras),
        ("self-test", lambda: _self_test(device)),
    )
    for what, check in checks:
        try:
            yield check()
        except MakeupVideoError as error:
            yield Finding(BAD, what, error_text(error))
        except Exception as error:  # noqa: BLE001  # every failure is a finding
            yield Finding(BAD, what, f"{type(error).__name__}: {' '.join(str(error).split())}")


def _own_version() -> str:
    from importlib.metadata import version

    return f"{version('makeup-video')}, Python {platform.python_version()}"


def _system() -> str:
    from makeup_video.pipeline.engine.machine import cores

    count = cores()
    many = "core" if count == 1 else "cores"
    return f"{platform.platform()}, {platform.machine()}, {count} {many}"


def _packages() -> Finding:
    """The versions of the libraries and extras that are installed."""
    from importlib.metadata import PackageNotFoundError, version

    found = []
    for name in (*_PACKAGES, *_EXTRAS):
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            continue
    return Finding(OK, "packages", ", ".join(found))


def _memory() -> Finding:
    from makeup_video.pipeline.engine.machine import free_memory_bytes

    free = free_memory_bytes()
    words = f"{free / 1e9:.1f} GB free"
    if free < _LITTLE_BYTES:
        return Finding(BAD, "memory", f"{words}: close other programs, painting takes about 1 GB")
    return Finding(OK, "memory", words)


def _opencl() -> Finding:
    from makeup_video.pipeline.render.opencl import lost_kernels, opencl_devices

    words = "; ".join(f"{number} {one}" for number, one in enumerate(opencl_devices()))
    if lost := lost_kernels():
        return Finding(NOTE, "OpenCL", f"{words}; {lost}")
    return Finding(OK, "OpenCL", words)


def _encoders() -> Finding:
    from makeup_video.pipeline.media.codecs import CODECS
    from makeup_video.pipeline.media.encoders import encoders_found, ffmpeg_version

    found = encoders_found()
    words = f"{', '.join(found)} (FFmpeg {ffmpeg_version()})"
    if missing := [name for name in CODECS if name not in found]:
        return Finding(BAD, "encoders", f"{words}; missing: {', '.join(missing)}: reinstall av")
    return Finding(OK, "encoders", words)


def _heic() -> Finding:
    from importlib.util import find_spec

    if find_spec("pi_heif") is None:
        return Finding(NOTE, "HEIC photos", "not read here: pip install pi-heif")
    return Finding(OK, "HEIC photos", "read by pi-heif")


def _cameras() -> Finding:
    from makeup_video.pipeline.live.sources.device import cameras_by_name

    found = [f"{name} {words}".strip() for name, words in cameras_by_name().items()]
    if not found:
        return Finding(NOTE, "cameras", "none: `live` needs one, or a file (--camera FILE)")
    return Finding(OK, "cameras", "; ".join(found))


def _self_test(device: str) -> Finding:
    from makeup_video.benchmark.self_test import self_test
    from makeup_video.pipeline.engine.machine import FIND_FACES, check_memory

    check_memory(FIND_FACES)
    done = self_test(device)
    stages = ", ".join(f"{name} {ms:.1f}" for name, ms in done.stages_ms.items())
    words = (
        f"720p, ready after {done.start_seconds:.1f} s, then {done.fps:.0f} fps on one thread "
        f"(ms a frame: {stages})"
    )
    if done.painted <= done.frames:  # `frames` leaves the first frame out
        return Finding(BAD, "self-test", f"{words}; a face was not found: please report this")
    if done.fps < _REAL_TIME_FPS:
        return Finding(
            NOTE,
            "self-test",
            f"{words}: slower than {_REAL_TIME_FPS} fps; close other programs",
        )
    return Finding(OK, "self-test", words)
