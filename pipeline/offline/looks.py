"""process_looks: paints several looks on one video or picture, which is read only once."""

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TypeVar

from makeup_video.pipeline.engine.machine import (
    FIND_FACES,
    check_memory,
    free_memory_bytes,
    give_back_last_run,
    one_opencv_thread,
)
from makeup_video.pipeline.errors import MakeupVideoError, StoppedError, UsageError, option
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.files.output_file import check_apart, check_place
from makeup_video.pipeline.files.path_argument import check_path
from makeup_video.pipeline.images.picture_file import is_picture
from makeup_video.pipeline.look.look import Look, check_look
from makeup_video.pipeline.media.duration import check_start
from makeup_video.pipeline.media.input_file import VideoSource, open_video
from makeup_video.pipeline.offline.encoding import choose_encoding
from makeup_video.pipeline.offline.report import Outcome, Report, RunClock
from makeup_video.pipeline.offline.run import check_picture_settings
from makeup_video.pipeline.offline.settings import Settings, check_progress, is_number

# (outputs that are being written, frames done, frames expected or None, frames/s of the source)
LooksProgress = Callable[[Sequence[Path], int, int | None, Fraction], None]
# a type variable, since a dict[str, Look] is not a Mapping[str | os.PathLike[str], Look]
_Output = TypeVar("_Output", bound=str | os.PathLike[str])
# With sixteen looks each bears a sixteenth of the shared work. More looks would save little and
# start hundreds of threads.
_MOST_AT_ONCE = 16


def process_looks(
    src: str | os.PathLike[str],
    looks: Mapping[_Output, Look],
    settings: Settings | None = None,
    on_progress: LooksProgress | None = None,
    memory_share: float = 0.5,
) -> dict[Path, Outcome]:
    """Paint each look on every frame of src, a video or a picture, and write it to its own output.

    Decoding, finding faces, smoothing and reading the scene happen once for all looks; painting and
    encoding once for each. The files are those that process_video would write, byte for byte.

    looks: by output; all outputs of a video have the same extension.
    settings: as in process_video, but without `split_minutes`; `on_whole` is called once, when all
    looks have ended and at least one output is whole.
    memory_share: the share of the free memory that encoders may take. Where it does not suffice for
    as many encoders as looks, or there are more than 16 looks, the video is read several times.
    on_progress(outputs, frames done, frames expected or None, frames per second of the source) is
    called a few times a second while a video is painted; outputs: those of the looks that are being
    painted.
    Returns for each output, as a Path, its report, or the error that ended this look alone, such as
    a full disk. The seconds of a report are those of all looks that were painted at the same time.
    Raises TypeError for an argument of a wrong type; one of `errors` before anything is written, or
    for what ends all looks: Ctrl-C, or an input that cannot be read while no output is whole yet.
    """
    check_path("src", src)
    if not isinstance(looks, Mapping):
        raise TypeError(f"looks must be a dict of outputs and looks, got {type(looks).__name__}")
    for output, look in looks.items():
        check_path("an output of looks", output)
        check_look(look)
    check_progress(on_progress)
    if not is_number(memory_share):
        raise TypeError(f"memory_share must be a number, got {memory_share!r}")
    if not 0 < memory_share <= 1:
        raise UsageError(f"memory_share must be more than 0 and at most 1, got {memory_share}")
    settings, path = Settings.checked(settings), local_file(src)
    _check_outputs(path, [Path(output) for output in looks], settings)
    outputs = {Path(output): look for output, look in looks.items()}
    check_memory(FIND_FACES)
    with one_opencv_thread():
        if is_picture(path):
            # late: the face nets and OpenCL take long to load
            from makeup_video.pipeline.offline.looks_on_picture import paint_picture

            check_picture_settings(src, settings)
            done = _timed(partial(paint_picture, path, outputs, settings))
        else:
            done = _on_video(path, outputs, settings, on_progress, memory_share)
    if settings.on_whole is not None and any(isinstance(one, Report) for one in done.values()):
        settings.on_whole()
    return done


def _on_video(
    path: Path,
    looks: Mapping[Path, Look],
    settings: Settings,
    on_progress: LooksProgress | None,
    memory_share: float,
) -> dict[Path, Outcome]:
    from makeup_video.pipeline.offline.looks_on_video import paint_video

    if settings.split_minutes is not None:
        raise UsageError(
            "several looks of one video are painted in one run: leave out "
            f"{option('split_minutes')}, or paint each look in a run of its own"
        )
    if len({output.suffix.lower() for output in looks}) > 1:
        raise UsageError("the outputs of several looks of one video must have one extension")
    done: dict[Path, Outcome] = {}
    while rest := {output: look for output, look in looks.items() if output not in done}:
        now = rest
        try:
            with closing(open_video(path)) as source:
                check_start(source, settings.start_seconds)
                at_once = encoders_at_once(source, next(iter(rest)), settings, memory_share)
                count = -(-len(rest) // -(-len(rest) // at_once))  # passes of about equal size
                now = dict(list(rest.items())[:count])
                tick = None if on_progress is None else partial(on_progress, list(now))
                more = len(now) < len(rest)
                done |= _timed(partial(paint_video, source, now, settings, tick, more))
        except StoppedError:
            raise
        except MakeupVideoError as error:
            if not done:
                raise
            done |= dict.fromkeys(now, error)  # the outputs of earlier passes are whole
            continue
        for output in rest.keys() - now.keys():  # a name may have been taken meanwhile
            try:
                check_place(os.fspath(output), path, overwrite=settings.overwrite)
            except MakeupVideoError as error:
                done[output] = error
    return {output: done[output] for output in looks}


def encoders_at_once(
    source: VideoSource, output: Path, settings: Settings, memory_share: float = 0.5
) -> int:
    """How many looks of a video are encoded at the same time: at least 1, at most 16, and no more
    than fit into a share of the free memory."""
    encoding = choose_encoding(source, output, settings)
    # MB per Mpx is bytes per px
    each_bytes = max(1, encoding.codec.memory_mb_per_mpx * encoding.frame_px)
    return max(1, min(_MOST_AT_ONCE, int(memory_share * free_memory_bytes() / each_bytes)))


def _check_outputs(source: Path, outputs: Sequence[Path], settings: Settings) -> None:
    """Refuse outputs that cannot be written, or of which one would replace another.

    Raises UsageError, OutputError.
    """
    if not outputs:
        raise UsageError("no look given: give at least one output with its look")
    check_apart(outputs)
    for output in outputs:
        check_place(os.fspath(output), source, overwrite=settings.overwrite)


def _timed(work: Callable[[], dict[Path, Outcome]]) -> dict[Path, Outcome]:
    """Do the work, write its times and memory into the reports, and free the memory it leaves."""
    clock = RunClock()
    try:
        done = work()
    finally:
        give_back_last_run()
    clock.write(*(outcome for outcome in done.values() if isinstance(outcome, Report)))
    return done
