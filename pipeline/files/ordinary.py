"""Opens ordinary files and nothing else: a pipe could block, and a device might never end."""

import errno
import os
import stat
from typing import IO

# O_NONBLOCK: opening a pipe into which nobody writes would block.
_READ = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def open_ordinary(path: str | os.PathLike[str], most_bytes: int) -> IO[bytes]:
    """Open an ordinary file of at most `most_bytes` for reading.

    Raises OSError whose `strerror` is a reason that people can read.
    """
    try:
        fd = os.open(path, _READ)
    except ValueError:  # a NUL in the name
        raise OSError(errno.EINVAL, "no file has such a name") from None
    try:
        state = os.fstat(fd)
        if stat.S_ISDIR(state.st_mode):
            raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
        if not stat.S_ISREG(state.st_mode):
            raise OSError(errno.EINVAL, "it is no ordinary file")
        if state.st_size > most_bytes:
            raise _too_large(most_bytes)
        return os.fdopen(fd, "rb")
    except BaseException:
        os.close(fd)
        raise


def read_ordinary(path: str | os.PathLike[str], most_bytes: int) -> bytes:
    """Read a whole file. Raises OSError as `open_ordinary` does, and when the file is growing."""
    with open_ordinary(path, most_bytes) as file:
        size = os.fstat(file.fileno()).st_size
        data = file.read(min(size, most_bytes) + 1)  # Python allocates as much as is asked for
    if size > most_bytes:
        raise _too_large(most_bytes)
    if len(data) > size:
        raise OSError(errno.EBUSY, "another program is writing it")
    return data


def _too_large(most_bytes: int) -> OSError:
    return OSError(errno.EFBIG, f"it has more than {most_bytes / 1e6:.0f} MB")
