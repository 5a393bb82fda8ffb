"""Renames a file without replacing anything that exists."""

import contextlib
import ctypes
import errno
import os
from pathlib import Path

# From Linux's <fcntl.h> and <linux/fs.h>
_AT_FDCWD = -100
_RENAME_NOREPLACE = 1


def rename_new(old: Path, new: Path) -> None:
    """Rename `old` to `new` in the same folder.

    Raises FileExistsError when anything has the name `new`, even a broken link, and OSError for any
    other reason. The system checks and renames in one step, by `renameat2` or a hard link. On a
    file system that has neither (exFAT, some network shares) the check comes first: a file that
    takes the name in the microseconds between is replaced.
    """
    if os.name == "nt":
        os.rename(old, new)  # on Windows it never replaces a file
        return
    for way in (_by_system, _by_link):
        try:
            way(old, new)
            return
        except FileExistsError:
            raise
        except (OSError, NotImplementedError):
            continue  # not supported here; the last way raises for any other reason
    _by_looking(old, new)


def _by_system(old: Path, new: Path) -> None:
    try:
        renameat2 = ctypes.CDLL(None, use_errno=True).renameat2
    except AttributeError:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS)) from None
    path = ctypes.c_char_p
    renameat2.argtypes = (ctypes.c_int, path, ctypes.c_int, path, ctypes.c_uint)
    if renameat2(_AT_FDCWD, os.fsencode(old), _AT_FDCWD, os.fsencode(new), _RENAME_NOREPLACE):
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code), os.fspath(new))


def _by_link(old: Path, new: Path) -> None:
    os.link(old, new, follow_symlinks=False)
    with contextlib.suppress(OSError):  # the file has its new name; the old one is a mere leftover
        old.unlink()


def _by_looking(old: Path, new: Path) -> None:
    if os.path.lexists(new):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), os.fspath(new))
    os.rename(old, new)
