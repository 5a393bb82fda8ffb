"""The folder where PoCL keeps compiled kernels: it must have room, and nothing is left behind there.

PoCL and LLVM end the process by SIGABRT when they cannot write there, so the room is tried first.
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
# 1.1 MB of it is taken for a moment (a source with all built-in functions), 0.25 MB for good.
ROOM_BYTES = 4 << 20  # a few runs may begin at once
_ROOM_FILES = 32  # one run makes 20 files and folders
_DAY_SECONDS = 86400
# Names of PoCL's temporary files. The one that PoCL makes when it starts has no suffix, and stays.
_TEMPORARY = re.compile(r"tempfile_\w{6}(\.[\w.-]+)?")
_own: list[str] = []  # folders that end with this process


class NoRoomError(OSError):
    """No folder takes the kernels."""


def settle() -> Path:
    """The folder that PoCL uses from now on: the user's, or one that lasts as long as this process.

    It is POCL_CACHE_DIR, else PoCL's own place; and one among the temporary files where neither can
    be written, has room, or may hold programs. Sets POCL_CACHE_DIR.  Raises NoRoomError.
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
            "POCL_CACHE_DIR to a folder that has it"
        )
    os.environ["POCL_CACHE_DIR"] = str(folder)
    return folder


@contextlib.contextmanager
def left_clean(folder: Path) -> Generator[None, None, None]:
    """Remove the empty file that PoCL makes when it starts, and what killed runs left a day ago.

    PoCL closes that file at once and never opens it again: should another process make its own
    within the block, that one may go too. Files that are in use have a suffix, and are younger.
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
    """Remove what killed runs left, once a process: there may be thousands of such files."""
    aged = time.time() - _DAY_SECONDS
    for name in _temporary(folder):
        with contextlib.suppress(OSError):
            if os.lstat(folder / name).st_mtime < aged:
                (folder / name).unlink()


def restore() -> None:
    """Make PoCL's folder again, which somebody may have removed meanwhile. Raises OSError."""
    Path(os.environ["POCL_CACHE_DIR"]).mkdir(parents=True, exist_ok=True)


def can_compile() -> bool:
    """True when PoCL finds a linker, or has compiled into its folder before.

    Without one it ends the process. It looks for `ld` on the PATH.
    """
    folder = Path(os.environ["POCL_CACHE_DIR"])
    return shutil.which("ld") is not None or any(folder.glob("*/*/*/*/*.so"))


def give_back() -> None:
    """Remove the folders that were to last as long as this process."""
    while _own:
        shutil.rmtree(_own.pop(), ignore_errors=True)


atexit.register(give_back)


def _usual() -> Path:
    """Where PoCL would keep them by itself; without a HOME, though, not in /tmp, where others could
    put programs of that name."""
    if given := os.environ.get("POCL_CACHE_DIR"):
        return Path(given).absolute()
    base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return Path(base) / "pocl" / "kcache"


def _try(folder: Path) -> str | None:
    """Why the folder does not do; None when it does. It is made if need be."""
    if not folder.is_absolute():  # "~", of a user without a home
        return f"{folder} is no absolute path"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        state = os.statvfs(folder)
        if state.f_flag & getattr(os, "ST_NOEXEC", 0):
            return f"{folder} may hold no programs (noexec)"
        if state.f_files and state.f_favail < _ROOM_FILES:
            return f"{folder} has no room for more files"
        _allocate(folder)
    except OSError as error:
        return f"{folder}: {error.strerror or error}"
    return None


def _allocate(folder: Path) -> None:
    """Take the room and give it back: a full disk, a quota and a limit of the process all show."""
    with tempfile.TemporaryFile(dir=folder) as file:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, ROOM_BYTES)
        else:  # macOS
            file.write(bytes(ROOM_BYTES))
            file.flush()
            os.fsync(file.fileno())


def _own_folder(place: str) -> tuple[Path | None, str | None]:
    """A new folder there, or why it cannot be."""
    try:
        # a name of its own: PoCL runs what it finds there, and others can write to /tmp
        folder = tempfile.mkdtemp(prefix="makeup-video-", dir=place)
    except OSError as error:
        return None, f"{place}: {error.strerror or error}"
    _own.append(folder)
    if reason := _try(Path(folder)):
        give_back()
        return None, reason.replace(folder, place)
    return Path(folder), None


def _temporary(folder: Path) -> set[str]:
    """Names of PoCL's temporary files."""
    try:
        return set(filter(_TEMPORARY.fullmatch, os.listdir(folder)))
    except OSError:
        return set()
