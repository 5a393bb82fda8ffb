"""Compiled programs in PoCL's folder, each in one file, which load without PoCL's compiler.

PoCL itself finds a compiled program by its preprocessed source. For that, Clang reads OpenCL's
built-in functions: 35 ms for each program, at every start. A binary is loaded in 3 ms.
"""

import contextlib
import hashlib
import os
import secrets
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyopencl as cl
from makeup_video.kernels.cache import has_linker

_DIGEST_BYTES = 32


def binary_file(device: Any, source: str, options: Sequence[str]) -> Path:
    """The file for a program of PoCL's device, in the folder that `cache.settle` chose."""
    words = device.name, device.version, device.driver_version, *options, source
    name = hashlib.sha256("\0".join(words).encode()).hexdigest()
    return Path(os.environ["POCL_CACHE_DIR"]) / f"{name}.binary"


def load_binary(context: Any, file: Path) -> Any | None:
    """The program in a file; None if there is no file, or its program cannot be used."""
    try:
        content = file.read_bytes()
    except OSError:
        return None
    digest, binary = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
    if hashlib.sha256(binary).digest() != digest:  # PoCL would trust a damaged binary and crash
        return None
    try:
        return cl.Program(context, context.devices, [binary]).build()
    except cl.Error:  # of another PoCL, or for another processor
        return None


def save_binary(program: Any, file: Path) -> bool:
    """Write the binary of a program at its second build; the first build leaves an empty file.

    For a binary PoCL also compiles all kernels of the program for any size of work-group. That
    takes 0.1 to 2 s, and in a container that is thrown away nobody would ever read the binary.
    Without a linker, PoCL would end the process, so nothing is written then, nor when PoCL fails or
    the disk is full. Returns True when it wrote a binary.
    """
    # at Ctrl-C LLVM deletes its temporary files, and PoCL fails without them
    with contextlib.suppress(OSError, cl.Error):
        if not file.exists():
            file.touch()
        elif has_linker():
            (binary,) = program.binaries
            _write(file, hashlib.sha256(binary).digest() + binary)
            return True
    return False


def _write(file: Path, content: bytes) -> None:
    """Write a file that other processes see whole or not at all. Raises OSError."""
    # named like PoCL's own files, so that `cache` removes what a killed run leaves
    part = file.with_name(f"tempfile_{secrets.token_hex(3)}.binary")
    try:
        part.write_bytes(content)
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
