"""Every error that the product raises on purpose.

    MakeupVideoError                 exit code 1
    ├── InstallError   (RuntimeError)          1   a file, extra or program is missing or changed
    ├── TooLittleMemoryError (MemoryError)     1   a memory limit is below what the run needs
    ├── WorkerError    (RuntimeError)          1   a process or machine that did the work is gone
    ├── UsageError     (ValueError)            2   options that do not fit together
    ├── LookError      (ValueError)            2   a look file that cannot be used
    ├── CatalogueError (ValueError)            2   a table of products that cannot be used
    ├── InputError     (OSError)               3   the input cannot be opened
    │   ├── DecodeError                        3   it opens, but no picture can be decoded
    │   └── PhotoError                         3   no look can be read from the photo
    │       └── SeveralFacesError              3   the photo shows several faces to choose from
    ├── OutputError    (OSError)               4   the output cannot be written
    │   └── EncodeError                        4   the encoder refuses
    ├── StrictError    (ValueError)            6   strict run, and something would be lost
    └── StoppedError   (InterruptedError)    130   Ctrl-C while a video is painted

Exit code 5 has no error of its own: the input was damaged, or some of several outputs failed (of a
batch, even all).
A message is one line: what was expected, what came, where, and what to do. It names options with
`option`, so that every reader sees the name that they know.
"""

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, ClassVar

EXIT_IN_PART = 5
_LAST_OF_THE_SYSTEM = 4096  # upper bound of its error numbers; FFmpeg's own lie far above
_ALIKE = 0.7  # ratio of difflib: a word this close to a known word is a mistyped one
# Characters of Unicode's private use area: file names and option names do not contain them.
_OPTION = re.compile("\ue000(.*?)\ue001(.*?)\ue001(.*?)\ue002", re.DOTALL)


def option(name: str, value: object = None) -> str:
    """Mark an option in a message.

    name: the option's name in Python.  value: what to set the option to, None to name it alone.
    `str(error)` reads `bit_depth` or `bit_depth=8`; the command has its own spelling, see
    `MakeupVideoError.spelled`.
    """
    return f"\ue000{name}\ue001{'' if value is None else repr(value)}\ue001{value}\ue002"


def closest(word: str, known: Iterable[str]) -> str | None:
    """The known word that a mistyped word may mean; None where no known word is close."""
    from difflib import get_close_matches  # only a message needs it

    return next(iter(get_close_matches(word, known, 1, _ALIKE)), None)


class MakeupVideoError(Exception):
    """Base of the tree; `exit_code` is what the command returns."""

    exit_code: ClassVar[int] = 1

    def __init__(self, message: str = "") -> None:
        super().__init__("")
        self._set_message(message)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._message,)

    def extend(self, *, before: str = "", after: str = "") -> None:
        """Add text to the message, such as the name of the file that the error is about."""
        self._set_message(before + self._message + after)

    def replace(self, old: str, new: str) -> None:
        """Replace part of the message, such as the path of a temporary file."""
        self._set_message(self._message.replace(old, new))

    def _set_message(self, message: str) -> None:
        self._message = message
        self.args = (_OPTION.sub(lambda found: _in_python(found[1], found[2]), message),)

    @property
    def marked(self) -> str:
        """The message with its options marked as `option` marks them."""
        return self._message

    def spelled(self, spell: Callable[[str, str | None], str]) -> str:
        """The message with every option as `spell(name, value)` writes it; value may be None."""
        return _OPTION.sub(
            lambda found: spell(found[1], found[3] if found[2] else None), self._message
        )


def cannot_keep(what: str, lost: str, advice: str = "Leave") -> "StrictError":
    """The error of a strict run in which something, such as an output, would lose something.

    advice: the beginning of a sentence that ends in "--strict out.", such as "Use .mkv, or leave".
    """
    strict = option("strict")
    return StrictError(f"{strict}: {what} cannot keep {lost}. {advice} {strict} out.")


def reason_of(error: Exception) -> str:
    """The message of the system or of FFmpeg, without error numbers and names of files."""
    return getattr(error, "strerror", None) or str(error)


def is_of_the_system(error: Exception) -> bool:
    """True for an error with an error number of the system, even where FFmpeg reports it."""
    return 0 < (getattr(error, "errno", None) or 0) < _LAST_OF_THE_SYSTEM


def _in_python(name: str, value: str) -> str:
    return f"{name}={value}" if value else name


class InstallError(MakeupVideoError, RuntimeError):
    pass


class TooLittleMemoryError(MakeupVideoError, MemoryError):
    pass


class WorkerError(MakeupVideoError, RuntimeError):
    pass


class UsageError(MakeupVideoError, ValueError):
    exit_code = 2


class LookError(MakeupVideoError, ValueError):
    exit_code = 2


class CatalogueError(MakeupVideoError, ValueError):
    exit_code = 2


class InputError(MakeupVideoError, OSError):
    exit_code = 3


class DecodeError(InputError):
    """shows_nothing: not one frame could be decoded."""

    def __init__(self, message: str = "", shows_nothing: bool = False) -> None:
        super().__init__(message)
        self.shows_nothing = shows_nothing

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._message, self.shows_nothing)


class PhotoError(InputError):
    pass


class SeveralFacesError(PhotoError):
    """faces: the faces to choose from, as `find_faces` returns them, the largest first.

    photo: the file that shows the faces; None for a photo in memory.
    """

    def __init__(
        self, message: str = "", faces: Sequence[Any] = (), photo: str | None = None
    ) -> None:
        super().__init__(message)
        self.faces = tuple(faces)
        self.photo = photo

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._message, self.faces, self.photo)


class OutputError(MakeupVideoError, OSError):
    exit_code = 4


class EncodeError(OutputError):
    pass


class StrictError(MakeupVideoError, ValueError):
    exit_code = 6


class StoppedError(MakeupVideoError, InterruptedError):
    exit_code = 130

    def __init__(self, message: str = "stopped by the user") -> None:
        super().__init__(message)
