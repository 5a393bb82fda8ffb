"""Compiled programs in PoCL's folder, each in one file, which load without PoCL's compiler.

PoCL finds what it has compiled by the source after preprocessing, for which Clang reads OpenCL's
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
    """The program in a file; None where there is none, or one that cannot be used."""
    try:
        content = file.read_bytes()
    except OSError:
        return None
    digest, binary = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
    if hashlib.sha256(binary).digest() != digest:  # PoCL would trust it and crash
        return None
    try:
        return cl.Program(context, context.devices, [binary]).build()
    except cl.Error:  # of another PoCL, or for another processor
        return None


def save_binary(program: Any, file: Path) -> bool:
    """Write a program that is built for the second time; the first time leaves an empty file.

    Returns True when it wrote one. For a binary PoCL compiles all kernels of the program for any
    size of work-group, too, which takes 0.1 to 2 s, and in a container that is thrown away nobody
    would ever read it. Without a linker this would end the process. Nothing is written when that
    fails, or when the disk is full.
    """
    # at Ctrl-C PoCL fails without the temporary files that LLVM deletes
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
    # like PoCL's own, so that `cache` removes what a killed run leaves
    part = file.with_name(f"tempfile_{secrets.token_hex(3)}.binary")
    try:
        part.write_bytes(content)
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
