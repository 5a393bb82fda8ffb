"""The file into which an output is written: always new, locked, never reached through a link."""

import atexit
import contextlib
import os
import stat
from pathlib import Path

from makeup_video.pipeline.errors import OutputError, UsageError, option
from makeup_video.pipeline.files.rename import rename_new

_NO_FOLLOW = getattr(os, "O_NOFOLLOW", 0)
_NEW = os.O_RDWR | os.O_CREAT | os.O_EXCL | _NO_FOLLOW | getattr(os, "O_BINARY", 0)
_OLD = os.O_RDWR | _NO_FOLLOW | getattr(os, "O_NONBLOCK", 0)
_OWN_FILES = Path("/proc/self/fd")  # Linux: the files that this process has open, by number
_open_parts: dict[int, Path] = {}  # of this process, by descriptor
_TRIES = 10  # another program may put a file there whenever one is removed


class PartFile:
    """A new file at `path`. While it is open, no other run can write to the same place.

    overwrite: remove what an earlier run left there. Of a link only the link is removed, and a file
    that has other names keeps its content under those.
    own_path: the path to write to. On Linux it leads to this very file, even when another program
    puts a link in the place of the part. Elsewhere it is the file's name, and only `rename` notices
    such a link.
    Raises UsageError when the place is taken, OutputError or OSError when it cannot be used.
    """

    def __init__(self, path: Path, *, overwrite: bool) -> None:
        self.path = path
        self._fd: int | None = _opened(path, overwrite)
        self.own_path = _own_path(path, self._fd)
        self._is_open = True
        if os.name == "nt":  # Windows has no such locks, and does not rename open files
            _open_parts.pop(self._fd, None)
            os.close(self._fd)
            self._fd = None

    def rename(self, new: Path, *, overwrite: bool) -> None:
        """Give the file its final name and close it.

        Raises FileExistsError when something has that name and overwrite is False, OutputError when
        the name of the part no longer belongs to this file.
        """
        if not self._has_its_name():
            raise OutputError(
                f"{self.path} was removed or replaced by another program while it was written: run "
                "again, or choose a folder to which nobody else writes"
            )
        if overwrite:
            os.replace(self.path, new)
        else:
            rename_new(self.path, new)
        self.close()

    def close(self) -> None:
        """Close the file and leave it to others. Harmless when it is closed already."""
        self._is_open = False
        if self._fd is not None:
            _open_parts.pop(self._fd, None)
            os.close(self._fd)
            self._fd = None

    def remove(self) -> None:
        """Remove the file unless it was closed. Never raises: it runs after another error."""
        if self._is_open:
            with contextlib.suppress(OSError):
                if self._has_its_name():  # while it is locked: later it may be another run's
                    self.path.unlink()
            self.close()

    def _has_its_name(self) -> bool:
        return self._fd is None or _is_at(self.path, self._fd)


def remove_empty() -> None:
    """Remove the parts that a Ctrl-C left open and empty, wherever in the run it came."""
    for fd, path in list(_open_parts.items()):
        with contextlib.suppress(OSError):
            if os.fstat(fd).st_size == 0 and _is_at(path, fd):
                path.unlink()


atexit.register(remove_empty)


def check_part(path: Path, overwrite: bool) -> None:
    """Raises what PartFile would raise for what is at `path` now."""
    try:
        kind = path.lstat().st_mode
    except FileNotFoundError:
        return
    if not (stat.S_ISREG(kind) or stat.S_ISLNK(kind)):
        raise OutputError(
            f"{path}, where the output would be written, is no file: choose another output"
        )
    if not overwrite:
        if stat.S_ISREG(kind) and _is_locked(path):
            raise _busy(path)
        raise UsageError(
            f"{path} exists, perhaps from a run that was stopped: add "
            f"{option('overwrite', True)} to overwrite it"
        )


def remove_ended(path: Path) -> None:
    """Remove the part of a run that has ended, if there is one.

    Raises UsageError when the run has not ended.
    """
    if not os.path.lexists(path):  # also False for a name that is too long
        return
    with contextlib.suppress(FileNotFoundError):
        check_part(path, overwrite=True)
        _remove_old(path)


def _opened(path: Path, overwrite: bool) -> int:
    """A descriptor of the new file, locked until it is closed or the process ends."""
    for _ in range(_TRIES):
        try:
            fd = os.open(path, _NEW, 0o666)
            _open_parts[fd] = path
        except FileExistsError:
            check_part(path, overwrite)
            _remove_old(path)
            continue
        if lock_file(fd) and _is_at(path, fd):
            return fd
        _open_parts.pop(fd, None)
        os.close(fd)
        break
    raise _busy(path)


def _remove_old(path: Path) -> None:
    """Remove a link, or the file of a run that has ended.

    Raises UsageError when the run has not ended.
    """
    with contextlib.suppress(FileNotFoundError):
        if path.is_symlink() or os.name == "nt":
            path.unlink()
            return
        fd = os.open(path, _OLD)
        try:
            if not lock_file(fd):
                raise _busy(path)
            if _is_at(path, fd):  # else another run has just begun to write there
                path.unlink()
        finally:
            os.close(fd)


def lock_file(fd: int) -> bool:
    """Lock an open file until it is closed; False when another run has locked it.

    True on systems and file systems without such locks.
    """
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):  # NFS raises the second for another run's lock
        return False
    except OSError:
        return True
    return True


def _is_locked(path: Path) -> bool:
    """True for the file of a run that has not ended; False where that cannot be known."""
    try:
        fd = os.open(path, _OLD)
    except OSError:
        return False
    try:
        return not lock_file(fd)
    finally:
        os.close(fd)


def _is_at(path: Path, fd: int) -> bool:
    """True when `path` itself, and not a link, is the name of the open file."""
    try:
        return os.path.samestat(path.lstat(), os.fstat(fd))
    except FileNotFoundError:
        return False


def _own_path(path: Path, fd: int) -> Path:
    own = _OWN_FILES / str(fd)
    with contextlib.suppress(OSError):
        if os.path.samestat(own.stat(), os.fstat(fd)):
            return own
    return path.absolute()


def _busy(path: Path) -> UsageError:
    return UsageError(
        f"another run is writing {path} at this moment: wait for it, or choose another output"
    )
