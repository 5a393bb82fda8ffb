"""Messages about files that cannot be read or written: the system's reason, and what to do."""

import errno

from makeup_video.pipeline.errors import reason_of

_TOO_MANY = "close other programs, or raise the limit on open files (ulimit -n)"
_READING = {
    errno.EACCES: "give yourself permission to read it",
    errno.EPERM: "give yourself permission to read it",
    errno.EISDIR: "give a file, not a folder",
    errno.ENOENT: "give a file on this machine",
    errno.EIO: "copy it to another disk, or give another file",
    errno.EMFILE: _TOO_MANY,
    errno.ENFILE: _TOO_MANY,
    errno.ENAMETOOLONG: "give a file with a shorter name",
    errno.EFBIG: "give a smaller file",
    errno.EBUSY: "wait until no other program uses it",
}
_WRITING = {
    errno.ENOSPC: "free some space, or choose another disk",
    errno.EDQUOT: "the quota is used up: free some space",
    errno.EFBIG: "the file grew larger than this disk or its limits allow",
    errno.EACCES: "choose a folder that you may write to",
    errno.EPERM: "choose a folder that you may write to",
    errno.EROFS: "choose a disk that is not read-only",
    errno.ENAMETOOLONG: "choose a shorter name",
}


def unreadable(what: object, error: OSError, as_what: str = "") -> str:
    """The line about a file that cannot be read.

    what: the start of the line.  as_what: as which kind of file, such as " as a look file".
    """
    advice = _READING.get(error.errno or 0, "give another file")
    return f"{what} cannot be read{as_what}: {reason_of(error)}; {advice}"


def unwritable(what: object, error: Exception, otherwise: str) -> str:
    """The line about a file that cannot be written.

    error: the system's or FFmpeg's.  otherwise: the advice for an error that `_WRITING` lacks.
    """
    advice = _WRITING.get(getattr(error, "errno", None) or 0, otherwise)
    return f"{what} cannot be written: {reason_of(error)}; {advice}"
