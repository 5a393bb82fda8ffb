"""The names that a template gives to outputs, and the folders of the outputs."""

import contextlib
import errno
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Self

from makeup_video.cli.looks_options import WantedLook

if TYPE_CHECKING:
    from makeup_video.pipeline.files.template import Template


def name_outputs(output: str, source: str, looks: Sequence[WantedLook]) -> list[str]:
    """The name of the output of each look.

    The output of a single look keeps a name without braces as it is. Raises UsageError for a
    template that does not fit, and for two outputs with the same name.
    """
    from makeup_video.pipeline.files.output_file import check_apart
    from makeup_video.pipeline.files.template import Origin

    if len(looks) == 1 and not {"{", "}"} & set(output):
        return [output]
    template = template_for(output, len(looks))
    fields = fields_of(Path(source))
    origins = [Origin(fields | look.fields, source, look.called) for look in looks]
    outputs = [template.fill(origin) for origin in origins]
    check_apart(outputs, origins)
    return list(map(os.fspath, outputs))


def template_for(output: str, looks: int) -> "Template":
    """The template of outputs. Raises UsageError if it would give several looks the same name."""
    from makeup_video.pipeline import UsageError
    from makeup_video.pipeline.files.template import OF_LOOKS, Template

    template = Template(output)
    if looks > 1 and not set(OF_LOOKS) & set(template.fields):
        raise UsageError(
            f"{looks} looks need a name each: put {{look}} in -o, as in "
            f"-o {_with_look(output)!r}, got {output}"
        )
    return template


def fields_of(path: Path) -> dict[str, str]:
    """The values of an input that a template of outputs may contain."""
    folder = path.absolute().parent.name
    return {"name": path.stem, "folder": folder, "ext": _written_as(path)}


def _written_as(path: Path) -> str:
    """The extension of an input's output: the input's own, or jpg or mp4 if that kind of file is
    only read, never written. An animated PNG counts as a video, which only its content shows."""
    from makeup_video.pipeline.files.endings import PHOTOS
    from makeup_video.pipeline.images.picture_file import WRITERS
    from makeup_video.pipeline.media.codecs import CONTAINERS

    end = path.suffix.lower()
    if end and end not in (*WRITERS, *CONTAINERS):
        return "jpg" if end in PHOTOS else "mp4"
    return "mp4" if end == ".png" and not _is_still(path) else end.removeprefix(".")


def _is_still(png: Path) -> bool:
    from makeup_video.pipeline import InputError
    from makeup_video.pipeline.files.local_file import local_file
    from makeup_video.pipeline.images.picture_file import is_picture

    try:
        return is_picture(local_file(png))
    except InputError:  # the job of this input reports the error
        return True


def _with_look(output: str) -> str:
    path = Path(output)
    if output.endswith(("/", os.sep)) or os.path.isdir(path):
        return os.fspath(path / "{name}-{look}.{ext}")
    return os.fspath(path.with_name(f"{path.stem}-{{look}}{path.suffix}")) if path.name else output


class NewFolders:
    """Makes the folders of outputs whose names come from a template.

    If the block ends with an error, the new folders that are empty are removed again.
    """

    def __init__(self) -> None:
        self._made: list[Path] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *exc: object) -> None:
        if kind is not None:
            for folder in reversed(self._made):
                with contextlib.suppress(OSError):
                    folder.rmdir()

    def make(self, outputs: Sequence[str]) -> None:
        """Make the folders of outputs. Raises OutputError."""
        from makeup_video.pipeline.files.output_file import write_errors

        for folder in dict.fromkeys(Path(output).parent for output in outputs):
            with write_errors(folder):
                missing = [one for one in (folder, *folder.parents) if not os.path.exists(one)]
                try:
                    folder.mkdir(parents=True, exist_ok=True)
                except OSError as error:
                    if error.errno != errno.ENAMETOOLONG:  # only the output of this name fails
                        raise
                self._made += [one for one in reversed(missing) if os.path.exists(one)]
