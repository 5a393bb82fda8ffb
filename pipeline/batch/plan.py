"""Plans what is left to do in a batch, by what its journal says was done before."""

import contextlib
import os
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from makeup_video.pipeline.batch.job import Done, Failed, Job, JobLook, Result
from makeup_video.pipeline.batch.journal import Entry, Journal, identity, result_of
from makeup_video.pipeline.batch.thumbnails import thumbnails
from makeup_video.pipeline.errors import (
    InputError,
    MakeupVideoError,
    OutputError,
    StrictError,
    UsageError,
    option,
)
from makeup_video.pipeline.files.output_file import (
    check_place,
    is_too_long,
    part_of,
    target_of,
)
from makeup_video.pipeline.files.part_file import remove_ended
from makeup_video.pipeline.images.picture_file import decode_picture, is_picture, read_bytes
from makeup_video.pipeline.media.probe import declared_frames, plays

# for an output whose job could not say what was dropped, changed or damaged
_UNKNOWN = (
    "what was lost or changed is not known, since its job was cut short: remove the file and run "
    "the batch again to paint it anew"
)
_ENDS_WITHIN_SECONDS, _AGAIN_SECONDS = 10.0, 0.2


@dataclass(slots=True)
class BatchPlan:
    """todo: jobs with the looks that are left.  known: results of earlier runs, by output."""

    todo: list[Job] = field(default_factory=list)
    known: dict[str, Result] = field(default_factory=dict)


def plan_batch(jobs: Iterable[Job], journal: Journal, *, retry: bool, overwrite: bool) -> BatchPlan:
    """Compare the jobs with the journal and with the files that are there.

    Finished outputs are checked by their size and by reading them. Parts that a killed run left are
    removed. An output whose name is too long becomes a job of its own, which fails alone.
    Raises UsageError or OutputError for an output whose place is not free.
    """
    plan = BatchPlan()
    for job in jobs:
        left, hopeless = set(), set()
        is_gone = identity(job.source) is None
        for look in job.looks:
            # an input may be archived once its outputs are done
            entry = journal.finished(job, look) if is_gone else journal.entry(job, look)
            result = None if entry is None else _known(job, look, entry, journal, retry=retry)
            if isinstance(result, _Changed) and not overwrite:
                result = Failed(look.output, result.error)
            if isinstance(result, Done | Failed):
                plan.known[look.output] = result
                continue
            if is_gone:
                left.add(look.output)  # fails alone
                continue
            if entry is not None:
                _remove_part(part_of(Path(look.output)))
            is_of_other_work = entry is None and journal.knows(look.output)
            try:
                _check_place(job, look, overwrite, is_of_other_work)
                left.add(look.output)
            except OutputError as error:
                if not is_too_long(error):
                    raise
                hopeless.add(look.output)
        plan.todo += [job.only(outputs) for outputs in (left, hopeless) if outputs]
    return plan


def is_hopeless(failed: Failed) -> bool:
    """Whether the same job would fail again in the same way: because of its options, of a name, or
    of an output that is not free."""
    if isinstance(failed.error, UsageError | StrictError):
        return True
    try:
        check_place(failed.output, None, overwrite=True)
    except MakeupVideoError as error:
        return is_too_long(error)
    return False


def _check_place(job: Job, look: JobLook, overwrite: bool, is_of_other_work: bool) -> None:
    """Raises UsageError, OutputError where the place is not free.

    The message says when the file there comes from other work in the journal.
    """
    try:
        check_place(look.output, Path(job.source), overwrite=overwrite)
    except UsageError as error:
        if is_of_other_work and os.path.lexists(look.output):
            error.extend(after=", since the journal has it from another input, look or settings")
        raise


def _remove_part(part: Path) -> None:
    """Remove the part that a killed run left. Its processes may need some seconds to end.

    Raises UsageError when another run is still writing the part.
    """
    for _ in range(round(_ENDS_WITHIN_SECONDS / _AGAIN_SECONDS)):
        with contextlib.suppress(UsageError):
            return remove_ended(part)
        time.sleep(_AGAIN_SECONDS)
    remove_ended(part)


@dataclass(frozen=True, slots=True)
class _Changed:
    """An output that is not what the batch wrote."""

    error: MakeupVideoError


def _known(
    job: Job, look: JobLook, entry: Entry, journal: Journal, *, retry: bool
) -> Result | _Changed | None:
    """The result of an earlier run; None where the work is to be done."""
    output, now = look.output, identity(look.output)
    if entry["event"] == "failed":
        return None if retry else result_of(output, entry)
    if now is None:
        return None
    if entry["event"] == "done":
        done = result_of(output, entry)
        if isinstance(done, Done) and now[1] == done.size and is_whole(output, done.frames):
            return done
        return _changed(output)
    was = None if entry["was"] is None else tuple(entry["was"])
    if now == was:
        return None
    adopted = adopt(replace(job.only({output}), was=(was,)), 0)
    if adopted is None:
        return _changed(output)
    journal.end(job.only({output}), [adopted])
    return adopted


def adopt(job: Job, at: int) -> Done | None:
    """The result for an output that a lost process has finished but not reported, if there is one.

    An output gets its name only when it is whole, so any new file of that name is whole.
    at: the output's place in the job.
    """
    output, was = job.looks[at].output, job.was[at]
    now = identity(output)
    if now is None or now == was or not is_whole(output):
        return None
    frames = 1 if is_picture(Path(output)) else declared_frames(Path(output))
    before, after = thumbnails(job.source, output, float(job.settings.start_seconds or 0))
    # a strict run would have refused any loss
    unknown = () if job.settings.strict else (_UNKNOWN,)
    return Done(output, now[1], frames, 0.0, unknown, False, before, after)


def _changed(output: str) -> _Changed:
    return _Changed(
        UsageError(
            f"{output} has changed since the batch wrote it, and is left alone: add "
            f"{option('overwrite', True)} to write it again"
        )
    )


def is_whole(output: str, frames: int | None = None) -> bool:
    """Whether a picture can be decoded, or a video plays; frames: as for `plays`."""
    path = Path(output)
    try:
        if not is_picture(path):
            return plays(path, frames)
        decode_picture(read_bytes(path, is_own=True), path)
    except InputError:
        return False
    return True


def check_inputs_apart(jobs: Sequence[Job], files: Iterable[str] = ()) -> None:
    """Raises UsageError for an output that would replace an input of the batch.

    files: further ones that the batch reads, such as look files.
    """
    inputs = {os.path.realpath(path): path for path in (*(job.source for job in jobs), *files)}
    for job in jobs:
        for look in job.looks:
            output = Path(look.output)
            for taken in (target_of(output), part_of(output)):
                if (read := inputs.get(os.path.realpath(taken))) is not None:
                    raise UsageError(
                        f"the output {look.output} would replace {read}, which this batch reads: "
                        "choose another name"
                    )
