"""Opens what is a file and nothing else: no pipe that is waited for, no device that never ends."""

import errno
import os
import stat
from typing import IO

_READ = (
    os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
)  # nobody writes into a pipe: opening it would wait


def open_ordinary(path: str | os.PathLike[str], most_bytes: int) -> IO[bytes]:
    """An ordinary file of at most `most_bytes`, open for reading.

    Raises OSError whose `strerror` is the reason, in words for people.
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
    """All of it. Raises OSError as open_ordinary does, and when the file grows meanwhile."""
    with open_ordinary(path, most_bytes) as file:
        size = os.fstat(file.fileno()).st_size
        data = file.read(min(size, most_bytes) + 1)  # Python takes memory for all that is asked for
    if size > most_bytes:
        raise _too_large(most_bytes)
    if len(data) > size:
        raise OSError(errno.EBUSY, "another program is writing it")
    return data


def _too_large(most_bytes: int) -> OSError:
    return OSError(errno.EFBIG, f"it has more than {most_bytes / 1e6:.0f} MB")
