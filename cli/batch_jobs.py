"""Turns the options of `batch` into its jobs."""

import contextlib
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from makeup_video.cli.console import log
from makeup_video.cli.look_options import faces_meant
from makeup_video.cli.looks_options import LooksOptions, WantedLook
from makeup_video.cli.outcome import join_words, option_of_command, some_of
from makeup_video.cli.output_names import NewFolders, fields_of, template_for
from makeup_video.cli.output_options import OutputOptions
from makeup_video.pipeline import Look, MakeupVideoError, Settings, UsageError
from makeup_video.pipeline.batch.job import Job, JobLook
from makeup_video.pipeline.batch.job_list import read_jobs
from makeup_video.pipeline.batch.journal import Journal
from makeup_video.pipeline.batch.plan import check_inputs_apart
from makeup_video.pipeline.batch.sources import (
    NOT_PAINTED,
    check_some_exist,
    inputs_of,
    left_out_of,
)
from makeup_video.pipeline.files.endings import PHOTOS, PICTURES, VIDEOS
from makeup_video.pipeline.files.output_file import check_apart
from makeup_video.pipeline.files.template import Origin, Template
from makeup_video.pipeline.images.picture_file import WRITERS
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.media.codecs import CONTAINERS

_JOURNAL, _PAGE = "makeup-video.jsonl", "index.html"
_LOOK_COLUMNS = ("look", "ref")  # each gives a whole look
_FACES = ("ref_face", "faces")
_CHANGES = (*_FACES, *PARTS, "color", "finish", "parts", "zone", "intensity", "strength")
_TIMES = ("start", "end")
_ENDINGS = (*CONTAINERS, *WRITERS)  # of videos and of pictures


@dataclass(frozen=True, slots=True)
class BatchJobs:
    """The jobs of a batch, its open journal, and the path of its page."""

    jobs: list[Job]
    journal: Journal
    page: Path

    @property
    def count(self) -> int:
        """How many outputs there are."""
        return sum(len(job.looks) for job in self.jobs)

    def changes_kind(self, outputs: Sequence[str]) -> bool:
        """Whether an output, by its name, would turn a picture into a video or a video into a
        picture."""
        sources = {look.output: job.source for job in self.jobs for look in job.looks}
        return any(
            one.lower().endswith(PHOTOS) != sources[one].lower().endswith(PHOTOS) for one in outputs
        )


@dataclass(frozen=True, slots=True)
class _Wanted:
    """One input, and how it is painted.

    where: the row of a list, for messages.
    is_beside_videos: a picture in a batch with videos; settings for videos only do not apply to it.
    """

    source: str
    output: str
    look: LooksOptions
    how: OutputOptions
    where: str = ""
    is_beside_videos: bool = False


def open_batch(
    inputs: Sequence[str],
    *,
    listed: str | None,
    look: LooksOptions,
    how: OutputOptions,
    output: str | None,
    journal: str | None,
    overwrite: bool,
    resume: bool,
    folders: NewFolders,
    quiet: bool,
) -> BatchJobs:
    """Check everything that can be checked before the work, and open the journal.

    Raises UsageError, LookError, CatalogueError, InputError, PhotoError, OutputError.
    """
    rows = [] if listed is None else list(_listed(listed, look, how, output))
    if not inputs and not rows:
        raise UsageError("no input given: add files, a folder, a pattern, or --list CSV")
    if inputs and output is None:
        raise UsageError(
            "-o/--output is missing: give a template such as 'out/{name}-{look}.{ext}'"
        )
    if output is None:
        folder = _folder_of([row.output for row in rows], listed or "")
    else:
        folder = Template(output).folder
    place = folder / _JOURNAL if journal is None else Path(journal)
    if resume and not os.path.isfile(place):
        raise UsageError(f"there is no journal {place} to go on with: leave --resume out")
    folders.make([os.fspath(place), os.fspath(folder / _PAGE)])
    opened = Journal(place)
    try:
        sources = inputs_of(inputs, opened.outputs) if inputs else []
        if not quiet:
            _log_left_out(inputs, sources)
        pictures = set()
        if sources:  # not for rows of a list, which have times of their own
            settings = how.settings(look, overwrite=overwrite)
            pictures = _pictures_beside_videos(sources, settings, quiet)
        wanted = [
            _Wanted(one, output or "", look, how, is_beside_videos=one in pictures)
            for one in sources
        ] + rows
        sources = [one.source for one in wanted]
        # When a batch is resumed, an input may be gone by now. But a name that does not end like a
        # video or a picture is more likely a mistyped folder.
        if not opened.outputs or not any(map(_is_media, sources)):
            check_some_exist(sources, wanted[0].where)
        jobs = _jobs(wanted, overwrite, quiet)
        folders.make([look.output for job in jobs for look in job.looks])
    except BaseException:
        opened.close()
        raise
    return BatchJobs(jobs, opened, folder / _PAGE)


def _pictures_beside_videos(sources: Sequence[str], settings: Settings, quiet: bool) -> set[str]:
    """The pictures in a batch with videos, if a setting was given that applies to videos only.

    One line logs that these pictures are painted without such settings, unless quiet.
    """
    pictures = set(filter(_is_picture, sources))
    given = [option_of_command(name, None) for name in settings.of_videos()]
    if not given or not pictures or len(pictures) == len(sources):
        return set()
    if not quiet:
        are = "1 picture is" if len(pictures) == 1 else f"{len(pictures)} pictures are"
        log(f"{are} painted without {join_words(given)}: for videos only")
    return pictures


def _is_picture(source: str) -> bool:
    return source.lower().endswith(PICTURES)


def _is_media(source: str) -> bool:
    return source.lower().endswith((*PICTURES, *VIDEOS))


def _log_left_out(given: Sequence[str], sources: Sequence[str]) -> None:
    """Log which of the given files are not painted: outputs of this batch that were given by name,
    and pictures in given folders whose kind cannot be painted."""
    kept = set(map(os.path.realpath, sources))
    named = {os.path.realpath(one) for one in given if os.path.isfile(one)}
    if outputs := len(named - kept):
        log(f"{outputs} of the files are outputs of this batch, and are not painted again")
    pictures = [Path(one).name for one in left_out_of(given) if os.path.realpath(one) not in kept]
    if pictures:
        files = "1 file" if len(pictures) == 1 else f"{len(pictures)} files"
        log(f"{files} left out: {some_of(pictures)} ({NOT_PAINTED} are not painted: save as PNG)")


def _folder_of(templates: Sequence[str], listed: str) -> Path:
    """The folder above all outputs of a list, or the list's own folder if they share none."""
    folders = {os.path.abspath(Template(one).folder) for one in templates}
    if len(folders) == 1:
        return Template(templates[0]).folder
    with contextlib.suppress(ValueError):  # the outputs lie on several drives
        shared = os.path.commonpath(folders)
        if os.path.dirname(shared) != shared:  # `shared` is not the root of a drive
            return Path(os.path.relpath(shared))
    return Path(listed).parent


def _listed(
    path: str, look: LooksOptions, how: OutputOptions, output: str | None
) -> Iterator[_Wanted]:
    for row in read_jobs(path, [*_LOOK_COLUMNS, *_CHANGES, *_TIMES]):
        template = row.output or output
        if template is None:
            raise UsageError(f"{row.where}: the column out is empty, and there is no -o: give one")
        changes: dict[str, Any] = {
            name: row.options[name] for name in _CHANGES if name in row.options
        }
        changes |= {name: faces_meant(changes[name]) for name in _FACES if name in changes}
        whole = {name: [row.options[name]] for name in _LOOK_COLUMNS if name in row.options}
        if whole:  # the row's look replaces all looks of the command
            of_looks = ("look", "ref", "looks", "catalogue", "where", "ref_face")
            none: dict[str, Any] = dict.fromkeys(of_looks)
            changes = none | changes | whole
        times: dict[str, Any] = {name: row.options[name] for name in _TIMES if name in row.options}
        yield _Wanted(
            row.source, template, replace(look, **changes), replace(how, **times), row.where
        )


def _jobs(wanted: Sequence[_Wanted], overwrite: bool, quiet: bool) -> list[Job]:
    """The jobs, once it is checked that all outputs differ and none is a file that is read."""
    looks: dict[str, list[tuple[WantedLook, Look]]] = {}
    jobs, files = [], set()
    origins: list[Origin] = []
    for one in wanted:
        try:
            key = repr(one.look)
            if key not in looks:  # only rows of a list may have looks of their own
                looks[key] = [(look, look.load(True)) for look in one.look.wanted(quiet)]
                files.update(one.look.files)
            its_origins = _origins(one, [look for look, _ in looks[key]])
            jobs.append(_job(one, looks[key], its_origins, overwrite))
            origins += its_origins
        except MakeupVideoError as error:
            if one.where:
                error.extend(before=f"{one.where}: ")
            raise
    outputs = [Path(look.output) for job in jobs for look in job.looks]
    check_apart(outputs, origins)
    check_inputs_apart(jobs, files)
    return jobs


def _origins(one: _Wanted, looks: Sequence[WantedLook]) -> list[Origin]:
    of_input = fields_of(Path(one.source))
    return [Origin(of_input | look.fields, one.source, look.called, one.where) for look in looks]


def _job(
    one: _Wanted,
    looks: Sequence[tuple[WantedLook, Look]],
    origins: Sequence[Origin],
    overwrite: bool,
) -> Job:
    end = Path(one.output).suffix.lower()
    if "{" not in end and end not in _ENDINGS:
        names = "{name}-{look}" if len(looks) > 1 else "{name}"
        example = os.path.join(
            os.path.dirname(one.output) if end else one.output, f"{names}.{{ext}}"
        )
        raise UsageError(
            f"--output must name files that end in {', '.join(_ENDINGS)}, as in -o {example!r}, "
            f"got {one.output!r}"
        )
    template = template_for(one.output, len(looks))
    settings = one.how.settings(one.look, overwrite=overwrite)
    return Job(
        one.source,
        tuple(
            JobLook(wanted.fields["look"], look, os.fspath(template.fill(origin)))
            for (wanted, look), origin in zip(looks, origins, strict=True)
        ),
        settings.for_pictures() if one.is_beside_videos else settings,
    )
