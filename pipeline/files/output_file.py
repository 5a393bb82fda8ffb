"""The output file: checked before the run, written under another name, renamed once whole."""

import contextlib
import errno
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Self

import av
from makeup_video.pipeline.errors import MakeupVideoError, OutputError, UsageError, option
from makeup_video.pipeline.files.disk_errors import unwritable
from makeup_video.pipeline.files.part_file import PartFile, check_part
from makeup_video.pipeline.files.template import Origin, field_between

_OVERWRITE = option("overwrite", True)


def target_of(path: Path) -> Path:
    """The file to write for `path`: the target of a link, so that the link itself stays.

    Raises OutputError for a name that no file can have.
    """
    if "\0" in str(path):
        raise OutputError(f"the output {str(path)!r} has a NUL in its name: leave it out")
    # os.path, not Path: with it a name that is too long counts as no link and raises nothing
    return Path(os.path.realpath(path)) if os.path.islink(path) else path


def part_path(path: Path) -> Path:
    """The name under which a file is written: NAME.part.EXT beside it."""
    return path.with_name(f"{path.stem}.part{path.suffix}")


def part_of(output: Path) -> Path:
    """The name under which the file behind `output` is written. Raises as target_of does."""
    return part_path(target_of(output))


def is_too_long(error: MakeupVideoError) -> bool:
    """True for the error of `check_place` or OutputFile about a name that is too long."""
    return isinstance(error.__cause__, OSError) and error.__cause__.errno == errno.ENAMETOOLONG


def keep_apart(output: Path, read: Path) -> None:
    """Raises UsageError when `output` would replace a file that the run only reads."""
    place = target_of(output)
    for taken in (place, part_path(place)) if place.name else ():
        if _is_same_file(taken, read):
            raise UsageError(
                f"the output {output} would replace {read}, which this run reads: choose another "
                "name"
            )


def check_apart(outputs: Sequence[Path], origins: Sequence[Origin] = ()) -> None:
    """Raises UsageError for two outputs that are one file.

    origins: what each output is made of, where names come from a template; else empty.
    """
    places: dict[str, int] = {}
    for at, output in enumerate(outputs):
        # case does not count: some disks do not distinguish A from a
        place = os.path.realpath(target_of(output)).lower()
        first = places.setdefault(place, at)
        if first == at:
            continue
        whose, advice = _apart(origins[first], origins[at]) if origins else ("", "")
        raise UsageError(
            f"two outputs have the name {output}{whose}: give each its own{advice}"
            if outputs[first] == output
            else f"two outputs are one file: {outputs[first]} and {output}{whose}; give each its "
            f"own name{advice}"
        )


def _apart(one: Origin, other: Origin) -> tuple[str, str]:
    """(what two outputs of one name are made of, the field that distinguishes them), in words."""
    pairs = (one.row or one.source, other.row or other.source), (one.look, other.look)
    whose = next((f" ({' and '.join(pair)})" for pair in pairs if len({"", *pair}) == 3), "")
    field = field_between(one, other)
    if field is not None:
        return whose, f", for example with {{{field}}}"
    return whose, "" if one.source == other.source else ", or rename an input"


def check_place(output: str, source: Path | None, *, overwrite: bool) -> None:
    """Check an output's place before the run does anything. Raises as OutputFile does.

    OutputFile checks again when it opens the file.
    """
    if not output:
        raise UsageError("the name of the output is empty: give one")
    with write_errors(Path(output)):
        path = target_of(Path(output))
        _check(path, source, overwrite)
        _check_part(part_path(path), source, overwrite)


class OutputFile:
    """One output. While it is open no other run can write to the same place.

    source: the file that is read, None for a camera.
    part: the name under which the output is written.  own_path: the path to write to, see PartFile.
    on_whole: called when the part is whole and about to get the output's name.
    Raises UsageError or OutputError, one line each, before anything is written.
    """

    def __init__(
        self,
        path: Path,
        source: Path | None,
        *,
        overwrite: bool,
        on_whole: Callable[[], None] | None = None,
    ) -> None:
        self._on_whole = on_whole
        with write_errors(path):
            self.path = target_of(path)
            self.part = part_path(self.path)
            self._overwrite = overwrite
            _check(self.path, source, overwrite)
            _check_part(self.part, source, overwrite)
            self._file = PartFile(self.part, overwrite=overwrite)
            self.own_path = self._file.own_path

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Keep the output when the block ended well, else discard it."""
        try:
            if kind is None:
                self.keep()
        finally:
            self.discard()

    def keep(self) -> None:
        """Give the part, which is whole, the output's name.

        Raises UsageError when another program has made a file of that name meanwhile and the run
        must not overwrite it. The part then stays.
        """
        if self._on_whole is not None:
            self._on_whole()
        with write_errors(self.path):
            try:
                self._file.rename(self.path, overwrite=self._overwrite)
            except FileExistsError:
                self.leave()
                raise UsageError(
                    f"{self.path} was made by another program during the run, and is left alone; "
                    f"what was written is {self.part}: rename it, or run again with {_OVERWRITE}"
                ) from None
            except OSError as error:
                if isinstance(error, OutputError):  # the part was replaced: see PartFile
                    raise
                self.leave()
                raise OutputError(
                    f"{self.part} cannot be renamed to {self.path} ({error.strerror}); it is "
                    "whole: rename it yourself"
                ) from error

    def leave(self) -> None:
        """Close the part and leave it under its own name."""
        self._file.close()

    def discard(self) -> None:
        """Remove the part unless it was kept or left. Never raises: it runs after another error."""
        self._file.remove()


def _check(path: Path, source: Path | None, overwrite: bool) -> None:
    folder = path.parent
    if not folder.is_dir():
        raise OutputError(f"the folder {folder} does not exist: make it, or choose another output")
    if path.is_dir():
        raise OutputError(f"{path} is a folder: give the name of a file in it")
    if not path.exists():
        return
    if not path.is_file():
        raise OutputError(f"{path} is not an ordinary file: choose another name")
    if source is not None and _is_same_file(path, source):
        raise UsageError(f"the output is the input ({source}): choose another name")
    if not overwrite:
        raise UsageError(
            f"{path} exists already: add {_OVERWRITE} to overwrite it, or choose another name"
        )


def _check_part(part: Path, source: Path | None, overwrite: bool) -> None:
    if source is not None and _is_same_file(part, source):
        raise UsageError(
            f"{source} has the name under which this output would be written: rename it, or choose "
            "another output"
        )
    check_part(part, overwrite)


def _is_same_file(one: Path, other: Path) -> bool:
    """True for two paths of one file; False when either is gone: an open input may be removed."""
    try:
        return one.samefile(other)
    except OSError:
        return False


class write_errors(contextlib.AbstractContextManager[None]):  # lower case: used like a function
    """Turns errors of FFmpeg and the system within the block into an OutputError about `path`."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, (av.FFmpegError, OSError)) and not isinstance(error, MakeupVideoError):
            otherwise = "choose another output or container"
            raise OutputError(unwritable(self.path, error, otherwise)) from error
