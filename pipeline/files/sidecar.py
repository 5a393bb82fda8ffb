"""JSON files that a run writes beside its output: the points, the report, or the look."""

import contextlib
import json
import os
from pathlib import Path
from typing import IO, Any, ClassVar, Self

from makeup_video.pipeline.errors import OutputError, StoppedError, UsageError
from makeup_video.pipeline.files.endings import PHOTOS, VIDEOS
from makeup_video.pipeline.files.local_file import ANY, local_file
from makeup_video.pipeline.files.output_file import OutputFile, part_of, write_errors


class Sidecar:
    """A file that is checked before the run and gets its name when the run has ended well.

    Until then it is written as NAME.part.EXT. After Ctrl-C the part stays as valid JSON, if
    anything was written to it; after an error it is removed.
    src: the run's input.  dst: the main output, None when there is none.
    others: more files of the run, which must not be replaced.
    wanted: what src must be, for messages.
    what: what messages call the file.  no_endings: extensions that the file must not have.
    begins, ends: text that is written before and after everything else.
    Raises InputError when src is not a file, UsageError or OutputError when the place is not free.
    """

    what: ClassVar[str]
    no_endings: ClassVar[tuple[str, ...]] = ()
    begins: ClassVar[str] = ""
    ends: ClassVar[str] = ""

    def __init__(
        self,
        path: str | os.PathLike[str],
        src: str | os.PathLike[str],
        dst: str | os.PathLike[str] | None,
        *others: str | os.PathLike[str],
        overwrite: bool = False,
        wanted: str = ANY,
    ) -> None:
        if not os.fspath(path):
            raise UsageError(f"the name of {self.what} is empty: give one")
        if os.fspath(path) == "-":  # for many programs the name of stdout
            raise UsageError(
                f"{self.what} is not written to stdout, got -: give a file, or ./- for one of that "
                "name"
            )
        source, self.path = local_file(src, wanted), Path(path)
        with write_errors(self.path):
            if self.path.is_dir() or os.fspath(path).endswith(os.sep):
                raise OutputError(f"{self.what} {path} is a folder: give the name of a file in it")
            written = [self.path] if dst is None else [self.path, Path(dst)]
            own = [source, *written[1:], *map(Path, others)]
            grows = [part_of(file) for file in written if file.name]
            if any(_is_same_place(a, b) for a in (self.path, grows[0]) for b in [*own, *grows[1:]]):
                raise UsageError(
                    f"{self.what} {path} is one of this run's own files, or has the name of a "
                    "part: choose another name"
                )
        if self.path.suffix.lower() in self.no_endings:
            raise UsageError(
                f"{self.what} {path} has the name of a picture or a video: end it in .json"
            )
        self._target = OutputFile(self.path, source, overwrite=overwrite)
        self._file: IO[str] | None = None

    def __enter__(self) -> Self:
        return self

    @property
    def is_begun(self) -> bool:
        """True once anything has been written."""
        return self._file is not None

    def append(self, text: str) -> None:
        """Write text. Raises OutputError when the file cannot be written."""
        with write_errors(self.path):
            if self._file is None:
                self._file = self._target.own_path.open("w", encoding="utf-8")
                self._file.write(self.begins)
            self._file.write(text)

    def __exit__(self, kind: type[BaseException] | None, error: object, trace: object) -> None:
        keep = kind is None
        leave = self.is_begun and kind is not None and issubclass(kind, StoppedError)
        try:
            if keep or leave:
                self.append(self.ends)
            if self._file is not None:
                with write_errors(self.path) if keep or leave else contextlib.suppress(OSError):
                    self._file.close()
            if keep:
                with write_errors(self.path):
                    self._target.keep()
            elif leave:
                self._target.leave()
            else:
                self._target.discard()
        except BaseException:
            self._target.discard()
            raise


class JsonFile(Sidecar):
    """A sidecar of one JSON object."""

    def write(self, values: dict[str, Any]) -> None:
        """Write the object. Raises OutputError when the file cannot be written."""
        self.append(json.dumps(values, indent=2) + "\n")


class ReportFile(JsonFile):
    """The JSON of `Report.to_dict`."""

    what = "the report"


class LookFile(JsonFile):
    """The JSON of `Look.to_dict`, which `Look.load` reads."""

    what = "the look file"
    no_endings = (*PHOTOS, *VIDEOS)  # `--look` would take it for a photo


def _is_same_place(one: Path, other: Path) -> bool:
    """True for two names of one file, or of the place where one file would be."""
    if one.exists() and other.exists():
        return one.samefile(other)
    return os.path.realpath(one) == os.path.realpath(other)
