"""Each line about a file that cannot be read or written says what to do."""

import errno
import os

import pytest
from makeup_video.pipeline.files.disk_errors import unreadable, unwritable


@pytest.mark.parametrize(
    ("code", "advice"),
    [
        (errno.EACCES, "give yourself permission to read it"),
        (errno.EISDIR, "give a file, not a folder"),
        (errno.EIO, "copy it to another disk, or give another file"),
        (errno.EMFILE, "close other programs, or raise the limit on open files (ulimit -n)"),
        (errno.ENXIO, "give another file"),
    ],
)
def test_the_advice_on_reading_fits_the_error(code, advice):
    reason = os.strerror(code)
    line = unreadable("in.mp4", OSError(code, reason, "/tmp/other"))
    assert line == f"in.mp4 cannot be read: {reason}; {advice}"


def test_an_error_without_a_number_has_its_own_words():
    error = OSError("it is gone")
    assert unreadable("in.mp4", error) == "in.mp4 cannot be read: it is gone; give another file"
    assert unwritable("a", error, "wait") == "a cannot be written: it is gone; wait"


def test_the_advice_on_writing_fits_the_error():
    line = unwritable("stdout", OSError(errno.ENOSPC, "full"), "send it to a file")
    assert line == "stdout cannot be written: full; free some space, or choose another disk"
    line = unwritable("stdout", OSError(errno.EIO, "gone"), "send it to a file")
    assert line == "stdout cannot be written: gone; send it to a file"
