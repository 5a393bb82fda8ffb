"""Every error that the product raises on purpose.

    MakeupVideoError                 exit code 1
    ├── InstallError   (RuntimeError)          1   a file of the package is missing or changed
    ├── TooLittleMemoryError (MemoryError)     1   a limit on memory that the run cannot keep
    ├── UsageError     (ValueError)            2   options that do not fit together
    ├── LookError      (ValueError)            2   a look file that cannot be used
    ├── CatalogueError (ValueError)            2   a table of products that cannot be used
    ├── InputError     (OSError)               3   the input cannot be opened
    │   ├── DecodeError                        3   it opens, but holds no picture to decode
    │   └── PhotoError                         3   a photo that no look can be read from
    │       └── SeveralFacesError              3   nor can be told whose it is meant to be
    ├── OutputError    (OSError)               4   the output cannot be written
    │   └── EncodeError                        4   the encoder refuses
    ├── StrictError    (ValueError)            6   --strict, and something would be lost
    └── StoppedError   (InterruptedError)    130   Ctrl-C

Exit code 5 is no error: the output is whole, but the input was damaged.
A message is one line: what was expected, what came, where, what to do. Options that it names are
written with `option`, so that readers find the name that they know.
"""

import re
from collections.abc import Callable
from typing import ClassVar

EXIT_DAMAGED_INPUT = 5
# Characters of Unicode's private use: no name of a file or an option holds them by chance.
_OPTION = re.compile("\ue000(.*?)\ue001(.*?)\ue001(.*?)\ue002", re.DOTALL)


def option(name: str, value: object = None) -> str:
    """An option in a message, by its name in Python; value: what to set it to, None for none.

    `str(error)` spells it `bit_depth` or `bit_depth=8`; the command spells it in its own way, see
    `MakeupVideoError.spelled`.
    """
    return f"\ue000{name}\ue001{'' if value is None else repr(value)}\ue001{value}\ue002"


class MakeupVideoError(Exception):
    """Base of the tree; `exit_code` is what the command returns."""

    exit_code: ClassVar[int] = 1

    def __init__(self, message: str = "") -> None:
        self._message = message
        super().__init__(_OPTION.sub(lambda found: _in_python(found[1], found[2]), message))

    def spelled(self, spell: Callable[[str, str | None], str]) -> str:
        """The message with every option as `spell(name, value)` writes it; value: None for none."""
        return _OPTION.sub(
            lambda found: spell(found[1], found[3] if found[2] else None), self._message
        )


def _in_python(name: str, value: str) -> str:
    return f"{name}={value}" if value else name


class InstallError(MakeupVideoError, RuntimeError):
    pass


class TooLittleMemoryError(MakeupVideoError, MemoryError):
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
    pass


class PhotoError(InputError):
    pass


class SeveralFacesError(PhotoError):
    pass


class OutputError(MakeupVideoError, OSError):
    exit_code = 4


class EncodeError(OutputError):
    pass


class StrictError(MakeupVideoError, ValueError):
    exit_code = 6


class StoppedError(MakeupVideoError, InterruptedError):
    exit_code = 130
