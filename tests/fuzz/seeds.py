"""The undamaged files that cases begin from, made once at the start of a run."""

import hashlib
import os
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import av
from fuzz import photos, texts, videos

KINDS = ("video", "photo", "text")
_WRITERS = {"video": videos.WRITERS, "photo": photos.WRITERS, "text": texts.WRITERS}


@dataclass(frozen=True)
class Seeds:
    """files: name -> bytes.  left_out: name -> why the file could not be made."""

    files: dict[str, bytes]
    left_out: dict[str, str]

    @property
    def mark(self) -> str:
        """A hash of all seeds: runs with the same mark have the same cases."""
        whole = hashlib.sha256()
        for name, data in self.files.items():
            whole.update(name.encode() + hashlib.sha256(data).digest())
        return whole.hexdigest()[:8]


def make_seeds(kind: str) -> Seeds:
    """Every seed of a kind. Seeds that FFmpeg or Pillow cannot make here are listed instead."""
    os.environ.setdefault("SVT_LOG", "-1")  # silences the AV1 encoder
    return make(_WRITERS[kind])


def make(writers: Mapping[str, Callable[[Path], None]]) -> Seeds:
    """The seeds from one writer per name."""
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
