"""The whole, sound files that cases begin from, made once at the start of a run."""

import hashlib
import os
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import av
from fuzz import films, photos, texts

KINDS = ("video", "photo", "text")
_WRITERS = {"video": films.WRITERS, "photo": photos.WRITERS, "text": texts.WRITERS}


@dataclass(frozen=True)
class Seeds:
    """files: what is in each, by its name.  left_out: what could not be made, and why."""

    files: dict[str, bytes]
    left_out: dict[str, str]

    @property
    def mark(self) -> str:
        """Cases are the same wherever this is: it stands for every byte of the seeds."""
        whole = hashlib.sha256()
        for name, data in self.files.items():
            whole.update(name.encode() + hashlib.sha256(data).digest())
        return whole.hexdigest()[:8]


def make_seeds(kind: str) -> Seeds:
    """Every seed of a kind. What this build of FFmpeg or Pillow cannot make is named instead."""
    os.environ.setdefault("SVT_LOG", "-1")  # the AV1 encoder prints on its own
    return make(_WRITERS[kind])


def make(writers: Mapping[str, Callable[[Path], None]]) -> Seeds:
    """What each writer writes, by its name."""
    files, left_out = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for name, write in writers.items():
            path = Path(folder) / name
            try:
                write(path)
            except (av.FFmpegError, OSError, ValueError, KeyError) as error:
                left_out[name] = f"{type(error).__name__}: {error}"
            else:
                files[name] = path.read_bytes()
    return Seeds(files, left_out)
