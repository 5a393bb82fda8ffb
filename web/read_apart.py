"""Decodes each visitor's photo in a process of its own, with limits on memory and time.

A file that breaks a decoder ends only that process, and the live picture goes on. A thread would
not be enough: Pillow sometimes holds Python's lock, and a large WebP stopped the live picture for
half a second.
"""

import json
import os
import subprocess
import sys

import numpy as np
from makeup_video.pipeline.errors import PhotoError

_SECONDS = 20.0  # for one photo; the largest ordinary photos take one or two
_MODULE = "makeup_video.web.photo_child"


def read_apart(photo: bytes, name: str) -> np.ndarray:
    """Decode a photo as `read_photo` does: (H, W, 3) uint8, read-only.

    photo: a file's bytes, called `name` in messages. Raises PhotoError with one line for the
    visitor, also when the process crashed or took too long.
    """
    # -P: nothing is imported from the folder where the run was started. The name goes to stdin,
    # like the photo, since other users of the machine can see arguments. OpenBLAS gets one thread:
    # more threads would only take time to start.
    command = [sys.executable, "-P", "-m", _MODULE]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            command,
            input=json.dumps(name).encode() + b"\n" + photo,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
            timeout=_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise PhotoError(
            f"{name} takes too long to read: save it again, or make it smaller"
        ) from None
    except OSError as error:
        raise PhotoError(f"{name} cannot be read now: {error.strerror}; try again later") from error
    if done.returncode != 0:
        raise PhotoError(f"{name} cannot be read: save it again as JPEG or PNG, or make it smaller")
    return _pixels(done.stdout)


def _pixels(answer: bytes) -> np.ndarray:
    """Read the answer of the process. Raises PhotoError when it refused the photo."""
    begin = answer.index(b"\n") + 1
    head = json.loads(answer[:begin])
    if isinstance(head, str):
        raise PhotoError(head)
    height, width = head
    return np.frombuffer(answer, np.uint8, offset=begin).reshape(height, width, 3)
