"""A process without network: the kernel ends the process if it tries to use one.

`python tests/support/sandbox.py quiet COMMAND ...` runs COMMAND and its children so that opening an
internet socket ends the process with SIGSYS. With `serves` instead of `quiet`, COMMAND may listen,
but neither connect nor send datagrams. The filter uses seccomp (Linux: seccomp(2),
linux/filter.h), which needs no privileges.
"""

import ctypes
import os
import platform
import struct
import subprocess
import sys
from functools import cache

# from linux/audit.h and the system call tables: (AUDIT_ARCH, socket, connect)
_MACHINES = {"x86_64": (0xC000003E, 41, 42), "aarch64": (0xC00000B7, 198, 203)}
_PR_SET_SECCOMP, _PR_SET_NO_NEW_PRIVS, _MODE_FILTER = 22, 38, 2
_LOAD, _EQUAL, _AND, _RETURN = 0x20, 0x15, 0x54, 0x06
_NUMBER, _ARCH, _FAMILY, _TYPE = 0, 4, 16, 24  # offsets in struct seccomp_data
_ALLOW, _KILL = 0x7FFF0000, 0x80000000
_INET, _INET6, _DATAGRAM = 2, 10, 2


@cache
def is_there() -> bool:
    """True if this Linux and this processor support the filters."""
    if sys.platform != "linux" or platform.machine() not in _MACHINES:
        return False
    trial = [sys.executable, __file__, "quiet", sys.executable, "-c", ""]
    return subprocess.run(trial, check=False, capture_output=True).returncode == 0


def forbid_network(*, serves: bool = False) -> None:
    """Cut off the network for this process and its children; this cannot be undone."""
    steps = _serving() if serves else _quiet()
    code = b"".join(struct.pack("HBBI", *step) for step in steps)
    memory = ctypes.create_string_buffer(code)
    program = struct.pack("HxxxxxxP", len(steps), ctypes.addressof(memory))
    libc = ctypes.CDLL(None, use_errno=True)
    for call in (
        (_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0),
        (_PR_SET_SECCOMP, _MODE_FILTER, ctypes.c_char_p(program), 0, 0),
    ):
        if libc.prctl(*call):
            raise OSError(ctypes.get_errno(), "no seccomp filter can be set")


def _quiet() -> list[tuple[int, int, int, int]]:
    """End the process on socket() with an internet family."""
    arch, socket, _ = _MACHINES[platform.machine()]
    return [
        (_LOAD, 0, 0, _ARCH),
        (_EQUAL, 0, 4, arch),  # another architecture jumps to the end, which kills
        (_LOAD, 0, 0, _NUMBER),
        (_EQUAL, 0, 3, socket),
        (_LOAD, 0, 0, _FAMILY),
        (_EQUAL, 2, 0, _INET),
        (_EQUAL, 1, 0, _INET6),
        (_RETURN, 0, 0, _ALLOW),
        (_RETURN, 0, 0, _KILL),
    ]


def _serving() -> list[tuple[int, int, int, int]]:
    """End the process on connect(), and on socket() for datagrams with an internet family."""
    arch, socket, connect = _MACHINES[platform.machine()]
    return [
        (_LOAD, 0, 0, _ARCH),
        (_EQUAL, 0, 10, arch),
        (_LOAD, 0, 0, _NUMBER),
        (_EQUAL, 8, 0, connect),
        (_EQUAL, 0, 6, socket),
        (_LOAD, 0, 0, _FAMILY),
        (_EQUAL, 1, 0, _INET),
        (_EQUAL, 0, 3, _INET6),
        (_LOAD, 0, 0, _TYPE),
        (_AND, 0, 0, 0xF),
        (_EQUAL, 1, 0, _DATAGRAM),
        (_RETURN, 0, 0, _ALLOW),
        (_RETURN, 0, 0, _KILL),
    ]


if __name__ == "__main__":
    forbid_network(serves=sys.argv[1] == "serves")
    os.execvp(sys.argv[2], sys.argv[2:])
