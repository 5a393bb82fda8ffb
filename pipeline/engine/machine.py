"""The machine's cores and memory: what a run may use, and what it gives back."""

import ctypes
import gc
import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from makeup_video.pipeline.errors import TooLittleMemoryError

try:
    import resource
except ImportError:  # Windows sets no such limits
    resource = None  # type: ignore[assignment]

_PROC = Path("/proc")
_GROUPS = Path("/sys/fs/cgroup")
_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3  # of glibc's mallopt
# Less than a plane of a 720p frame (0.9 MB). More than the lip net takes for each face (0.7 MB),
# since the system fills a large block with zeros, page by page, whenever it gives one out.
_LARGE_BLOCK_BYTES = 3 << 18
_KEPT_BYTES = 1 << 20  # free memory that glibc may keep at the end of its heap
_GIVE_BACK_SECONDS = 1.0
_given_back_at = 0.0


@dataclass(frozen=True, slots=True)
class Need:
    """The memory of a job, in MB.

    Each tuple is (at least, more per core, more per Mpx of a frame, more per Mpx and core).
    name: of the job, for messages.
    address_mb: address space, with libraries and the stacks of threads.
    held_mb: memory that is filled, without pages of files.
    """

    name: str
    address_mb: tuple[int, int, int, int]
    held_mb: tuple[int, int, int, int]


# Fitted to the peaks of VmSize and RssAnon on 1 and 2 cores, for frames of 64x64, 720p, 1080p and
# 2160p and a picture of 1.2 Mpx. Runs that paint compiled their kernels first, which takes 70 MB.
# With 10 % less, codecs and ONNX Runtime fail at some point, and PoCL and the threads of C
# libraries crash.
LOAD = Need("loading its libraries", (180, 45, 0, 0), (40, 0, 0, 0))
COPY_VIDEO = Need("copying this video", (400, 40, 38, 42), (35, 0, 47, 28))
SHOW_VIDEO = Need("looking for faces in this video", (605, 230, 55, 42), (100, 0, 58, 29))
PAINT_VIDEO = Need("painting this video", (985, 200, 55, 42), (235, 0, 58, 29))
FIND_FACES = Need("looking for faces", (660, 200, 0, 0), (80, 0, 0, 0))
PAINT_PICTURE = Need("painting this picture", (775, 200, 0, 0), (215, 0, 0, 0))
READ_PHOTO = Need("reading a look from a photo", (920, 285, 0, 0), (270, 0, 0, 0))
_MEASURED_CORES = 2  # nothing was measured on more cores


def check_memory(need: Need, frame_px: int = 0) -> None:
    """Raises TooLittleMemoryError when a limit on this process is too low for the job.

    frame_px: pixels of a frame of the video. Limits that the system does not report are ignored.
    """
    count, mpx = min(cores(), _MEASURED_CORES), frame_px / 1e6
    address, held = (
        round((least + core * count + (per_px + both * count) * mpx) * 1e6)
        for least, core, per_px, both in (need.address_mb, need.held_mb)
    )
    allowed = _address_limit_bytes()
    if allowed is not None and allowed < address:
        raise TooLittleMemoryError(_line(need, address, "address space", allowed, "ulimit -v"))
    group = group_limit_bytes()
    if group is not None and group < held:
        raise TooLittleMemoryError(
            _line(need, held, "memory", group, "the limit of its control group or container")
        )


def _address_limit_bytes() -> int | None:
    """The limit on this process's address space; None where there is none."""
    if resource is None:
        return None
    allowed = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if allowed == resource.RLIM_INFINITY else allowed


def _line(need: Need, wanted: int, what: str, allowed: int, limit: str) -> str:
    return (
        f"{need.name} needs about {wanted / 1e6:.0f} MB of {what}, and this process may take "
        f"{allowed / 1e6:.0f} MB ({limit}): raise that limit"
    )


def group_limit_bytes() -> int | None:
    """The memory limit of this process's control group, or of one above it.

    None where there is no limit, where the system does not report it, or where swap space softens
    it.
    """
    try:
        lines = (_PROC / "self" / "cgroup").read_text(encoding="ascii").splitlines()
        if any(swap.split()[1] != "0" for swap in _lines_of("meminfo", "SwapTotal:")):
            return None
    except (OSError, ValueError):
        return None  # another system than Linux, or /proc is hidden
    limits: list[int] = []
    for line in lines:
        _, controllers, path = line.split(":", 2)
        if controllers == "":
            limits += _limits(_GROUPS, path, "memory.max")
        elif "memory" in controllers.split(","):
            limits += _limits(_GROUPS / "memory", path, "memory.limit_in_bytes")
    return min(limits, default=None)


def _limits(root: Path, path: str, name: str) -> list[int]:
    """The limits of a group and of those above it; in a container only the root may be visible."""
    found = []
    group = root / path.lstrip("/")
    for folder in (group, *group.parents):
        try:
            text = (folder / name).read_text(encoding="ascii").strip()
        except (OSError, ValueError):
            text = ""
        if text.isdecimal():  # "max" is no limit
            found.append(int(text))
        if folder == root:
            break
    return found


def _lines_of(name: str, begins: str) -> list[str]:
    text = (_PROC / name).read_text(encoding="ascii")
    return [line for line in text.splitlines() if line.startswith(begins)]


def free_memory_bytes() -> int:
    """How much more memory this process may hold, as far as the system states it.

    A limit of a control group counts as a whole, whatever the group holds already.
    """
    free = [1 << 40] if (group := group_limit_bytes()) is None else [group]
    with suppress(OSError, ValueError):
        free += [int(line.split()[1]) * 1024 for line in _lines_of("meminfo", "MemAvailable:")]
    allowed = _address_limit_bytes()
    if allowed is not None:
        with suppress(OSError, ValueError):
            taken = [int(line.split()[1]) * 1024 for line in _lines_of("self/status", "VmSize:")]
            free.append(max(0, allowed - sum(taken)))
    return min(free)


def peak_memory_bytes() -> int:
    """The most memory that this process has held so far (its resident set); 0 on Windows."""
    if sys.platform == "linux":
        # getrusage includes the parent's memory from before exec, but works where /proc is hidden
        with suppress(OSError, ValueError):
            for line in _lines_of("self/status", "VmHWM:"):
                return int(line.split()[1]) * 1024
    if resource is None:
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024  # others count in kB


def cpu_seconds_of_children() -> float | None:
    """CPU time of the child processes that have ended, and of theirs; None on Windows."""
    if resource is None:
        return None
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def return_large_blocks() -> None:
    """Let glibc return every large block to the system as soon as it is freed, in this process.

    By itself glibc treats every block up to the size of the largest one freed so far as small, and
    keeps such blocks for the thread that freed them: 13 MB at 1080p. Meant for processes that we
    start ourselves.
    """
    set_option = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    if set_option is not None:
        set_option(_M_MMAP_THRESHOLD, _LARGE_BLOCK_BYTES)
        set_option(_M_TRIM_THRESHOLD, _KEPT_BYTES)


def seek_garbage() -> None:
    """Turn Python's garbage collection on where it is off, but exempt the objects made so far.

    Imports make a hundred thousand objects, and hardly one of them is garbage. Looking through them
    takes 0.1 s of a short run. So a command begins with the collection off, and calls this when
    most of what it needs is loaded.
    """
    if not gc.isenabled():
        gc.freeze()
        gc.enable()


def give_back_last_run() -> None:
    """Free the memory that a run has left, at most once a second, since that takes 30 ms.

    By itself glibc keeps most of the freed memory, and Python looks for garbage only after dozens
    of runs.
    """
    global _given_back_at
    now = time.monotonic()
    if now - _given_back_at >= _GIVE_BACK_SECONDS:
        gc.collect()
        _trim()
        _given_back_at = time.monotonic()


def give_back_memory() -> None:
    """Return freed memory to the system: glibc would keep it, and the video would allocate more."""
    gc.collect(1)  # recent objects only: looking through all modules, too, takes 30 ms
    _trim()


def _trim() -> None:
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # not in musl, which keeps less
        if trim is not None:
            trim(0)


def cores() -> int:
    """The number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def one_opencv_thread() -> Iterator[None]:
    """Keep OpenCV on the thread that calls it within the block.

    Pictures of lips and eyes are too small to share: waking OpenCV's own threads for them costs
    0.7 ms of CPU time per frame and makes no run shorter. The setting holds for the whole process.
    Where blocks overlap in several threads, it lasts until the last of them has ended.
    """
    _opencv.enter()
    try:
        yield
    finally:
        _opencv.leave()


class _OpenCVThreads:
    """The number of OpenCV's threads, kept at one while anybody wants that."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._wanted = 0  # blocks that have not ended
        self._before = 0
        self._at_fork: int | None = None

    def enter(self) -> None:
        import cv2  # late: `check_memory` must run before large libraries are loaded

        with self._lock:
            if not self._wanted:
                self._before = cv2.getNumThreads()
                cv2.setNumThreads(1)
            self._wanted += 1

    def leave(self) -> None:
        import cv2

        with self._lock:
            self._wanted -= 1
            if not self._wanted:
                cv2.setNumThreads(self._before)

    def before_fork(self) -> None:
        """End OpenCV's threads: a forked process has none of them, and would wait for them."""
        self._lock.acquire()
        cv2 = sys.modules.get("cv2")
        if cv2 is not None and hasattr(cv2, "setNumThreads"):  # else it is being imported
            self._at_fork = cv2.getNumThreads()
            cv2.setNumThreads(1)

    def after_fork(self) -> None:
        """Let parent and child have as many threads as before; OpenCV starts them when needed."""
        if self._at_fork is not None:
            sys.modules["cv2"].setNumThreads(self._at_fork)
            self._at_fork = None
        self._lock.release()


_opencv = _OpenCVThreads()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(
        before=_opencv.before_fork,
        after_in_parent=_opencv.after_fork,
        after_in_child=_opencv.after_fork,
    )
