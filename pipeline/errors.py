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
A message is one line: what was expected, what came, where, what to do.
"""

from typing import ClassVar

EXIT_DAMAGED_INPUT = 5


class MakeupVideoError(Exception):
    """Base of the tree; `exit_code` is what the command returns."""

    exit_code: ClassVar[int] = 1


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
