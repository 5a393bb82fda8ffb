"""The folder where PoCL keeps compiled kernels: checked for room, and cleaned of temporary files.

PoCL and LLVM end the process with SIGABRT when they cannot write there, so room is tested first.
"""

import atexit
import contextlib
import os
import re
import shutil
import tempfile
import time
from collections.abc import Generator
from functools import cache
from pathlib import Path

# Measured with PoCL 3.0 on a small tmpfs: painting a video failed with 1 MB and worked with 1.5 MB.
# PoCL needs 1.1 MB of that for a moment (a source with all built-in functions), and keeps 0.25 MB.
# With binaries, painting worked with 3 MB and failed with 2; a look of three layers keeps 1.7 MB.
ROOM_BYTES = 8 << 20  # a few runs may start at once
_ROOM_FILES = 128  # one run makes 80 files and folders
_DAY_SECONDS = 86400
# Names of PoCL's temporary files. PoCL makes one without a suffix at its start, and leaves it.
_TEMPORARY = re.compile(r"tempfile_\w{6}(\.[\w.-]+)?")
_own: list[str] = []  # folders that are removed when this process ends
_lost: list[str] = []  # why the usual folder cannot be used, where one of _own takes its place


class NoRoomError(OSError):
    """No folder can hold the compiled kernels."""


def settle() -> Path:
    """Choose the folder that PoCL uses from now on, and set POCL_CACHE_DIR to it.

    The choice is POCL_CACHE_DIR, else PoCL's default. If that folder cannot be written, lacks room
    or must not hold programs, the choice is a temporary folder that is removed when this process
    ends; `why_not_kept` then says why. Raises NoRoomError.
    """
    usual = _usual()
    reasons = [_try(usual)]
    folder: Path | None = usual
    if reasons[0] is not None:
        places = dict.fromkeys((tempfile.gettempdir(), "/var/tmp"))
        folder = None
        for place in places:
            folder, reason = _own_folder(place)
            reasons.append(reason)
            if folder is not None:
                break
    if folder is None:
        raise NoRoomError(
            f"the kernels that paint need a folder with {ROOM_BYTES >> 20} MB of room, found none: "
            f"{'; '.join(reason for reason in reasons if reason)}. Free some space, or set "
            "POCL_CACHE_DIR to a folder with room"
        )
    os.environ["POCL_CACHE_DIR"] = str(folder)
    if str(folder) not in _own:
        _lost.clear()
    elif reasons[0] is not None:
        _lost[:] = [reasons[0]]
    return folder


def why_not_kept() -> str | None:
    """Why the next process has to compile the kernels again; None when it does not have to."""
    return _lost[0] if _lost else None


@contextlib.contextmanager
def left_clean(folder: Path) -> Generator[None, None, None]:
    """Remove the empty file that PoCL makes at its start, and day-old leftovers of killed runs.

    PoCL closes the empty file at once and never opens it again, so the empty file of another
    process that starts within the block may be removed, too. Files in use have a suffix, and are
    less than a day old.
    """
    before = _temporary(folder)
    try:
        yield
    finally:
        for name in _temporary(folder) - before:
            path = folder / name
            with contextlib.suppress(OSError):
                if not path.suffix and path.lstat().st_size == 0:
                    path.unlink()
        _sweep(folder)


@cache
def _sweep(folder: Path) -> None:
    """Remove the files that killed runs left, once per process: there may be thousands."""
    aged = time.time() - _DAY_SECONDS
    for name in _temporary(folder):
        with contextlib.suppress(OSError):
            if os.lstat(folder / name).st_mtime < aged:
                (folder / name).unlink()


def restore() -> None:
    """Make PoCL's folder again, in case somebody removed it. Raises OSError."""
    Path(os.environ["POCL_CACHE_DIR"]).mkdir(parents=True, exist_ok=True)


def can_compile() -> bool:
    """True when PoCL finds the linker `ld` on the PATH, or has compiled into its folder before.

    PoCL ends the process when it has to link without a linker.
    """
    folder = Path(os.environ["POCL_CACHE_DIR"])
    return has_linker() or any(folder.glob("*/*/*/*/*.so"))


def has_linker() -> bool:
    """True when the linker `ld`, which PoCL runs, is on the PATH."""
    return shutil.which("ld") is not None


def give_back() -> None:
    """Remove the temporary folders of this process."""
    while _own:
        shutil.rmtree(_own.pop(), ignore_errors=True)


atexit.register(give_back)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_own.clear)  # the folders still belong to the parent


def _usual() -> Path:
    """Return POCL_CACHE_DIR or PoCL's default folder.

    Without a HOME, PoCL would use /tmp, where other users could put programs of the same name.
    """
    if given := os.environ.get("POCL_CACHE_DIR"):
        return Path(given).absolute()
    base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return Path(base) / "pocl" / "kcache"


def _try(folder: Path) -> str | None:
    """Make the folder where it is missing. Return why it cannot be used, None when it can."""
    if not folder.is_absolute():  # "~", of a user without a home
        return f"{folder} is not an absolute path"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if hasattr(os, "statvfs"):  # not on Windows
            state = os.statvfs(folder)
            if state.f_flag & getattr(os, "ST_NOEXEC", 0):
                return f"{folder} must not hold programs (noexec)"
            if state.f_files and state.f_favail < _ROOM_FILES:
                return f"{folder} has no room for more files"
        _allocate(folder)
    except OSError as error:
        return f"{folder}: {error.strerror or error}"
    return None


def _allocate(folder: Path) -> None:
    """Take the room and release it: fails on a full disk, a quota or a limit of the process."""
    with tempfile.TemporaryFile(dir=folder) as file:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, ROOM_BYTES)
        else:  # macOS, Windows
            file.write(bytes(ROOM_BYTES))
            file.flush()
            os.fsync(file.fileno())


def _own_folder(place: str) -> tuple[Path | None, str | None]:
    """Make a new folder in `place`: (folder, None), or (None, why it cannot be used)."""
    try:
        # a random name: PoCL runs what it finds in the folder, and other users can write to /tmp
        folder = tempfile.mkdtemp(prefix="makeup-video-", dir=place)
    except OSError as error:
        return None, f"{place}: {error.strerror or error}"
    _own.append(folder)
    if reason := _try(Path(folder)):
        _own.remove(folder)
        shutil.rmtree(folder, ignore_errors=True)
        return None, reason.replace(folder, place)
    return Path(folder), None


def _temporary(folder: Path) -> set[str]:
    """List the names of PoCL's temporary files."""
    try:
        return set(filter(_TEMPORARY.fullmatch, os.listdir(folder)))
    except OSError:
        return set()
