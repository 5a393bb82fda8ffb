"""Runs a file through the pipeline: source -> stages -> sink, and a report."""

import os
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, cast

from makeup_video.pipeline.engine.runner import Runner, Stage
from makeup_video.pipeline.errors import UsageError, option
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.images.picture_file import is_picture
from makeup_video.pipeline.media.duration import check_start
from makeup_video.pipeline.media.input_file import VideoSource, open_video
from makeup_video.pipeline.media.side_by_side import SideBySide
from makeup_video.pipeline.offline.picture import process_picture
from makeup_video.pipeline.offline.report import Report, RunClock
from makeup_video.pipeline.offline.settings import Settings
from makeup_video.pipeline.offline.video import Progress, add_times, begin_video, channel_frames


def run_stages(
    src: str | os.PathLike[str],
    dst: str | os.PathLike[str],
    stages: Callable[[VideoSource | None], list[tuple[str, Stage]]],
    settings: Settings,
    on_progress: Progress | None,
) -> Report:
    """Read src, run every frame through the stages, write dst.

    stages(source), or stages(None) for a picture, is called before the output is begun. Together
    the stages turn a Frame into a Frame; for a picture none of them may look ahead.
    on_progress: see process_video.  Raises one of `errors`; dst is then missing, or unchanged.
    """
    clock, path = RunClock(), local_file(src)
    check_name(dst)
    if is_picture(path):
        check_picture_settings(src, settings)
        paint = partial(_through, stages(None))
        report = process_picture(path, Path(dst), paint, settings)
    else:
        with closing(open_video(path)) as source:
            check_start(source, settings.start_seconds)
            steps = stages(source)
            if settings.compare:
                steps = compared(steps)
            report = _run(source, Path(dst), steps, settings, on_progress)
    clock.write(report)
    return report


def check_picture_settings(src: str | os.PathLike[str], settings: Settings) -> None:
    """Raises UsageError for settings that a picture does not have."""
    if given := settings.of_videos():
        names = ", ".join(map(option, given))
        raise UsageError(f"{src} is a picture: leave out {names} (for videos only)")


def _through(stages: list[tuple[str, Stage]], frame: Frame) -> Frame:
    """A single frame through all stages."""
    item: Any = frame
    for _, stage in stages:
        item = stage(item)
    return cast(Frame, item)


def compared(stages: list[tuple[str, Stage]]) -> list[tuple[str, Stage]]:
    """Show a frame before and after the last stage, which paints; without stages, show it twice."""
    *others, (name, last) = stages or [("compare", lambda frame: frame)]
    return [*others, (name, SideBySide(last))]


def _run(
    source: VideoSource,
    output: Path,
    stages: list[tuple[str, Stage]],
    settings: Settings,
    on_progress: Progress | None,
) -> Report:
    with begin_video(source, output, settings) as video:
        runner = Runner(
            ("decode", video.decoder.frames()),
            stages,
            ("encode", video.encoder),
            channel_frames(source),
            observe=settings.observe,
            threads=settings.stage_threads,
        )
        tick = on_progress
        expected = video.decoder.expected_frames
        runner.run(tick and (lambda done: tick(done, expected, source.rate)))
    report = video.report()
    add_times(report, runner.times, runner.channels)
    return report


def check_name(dst: str | os.PathLike[str]) -> None:
    """Raises UsageError for an output that names a folder."""
    if os.fspath(dst).endswith(os.sep):
        raise UsageError(f"the output {dst} names a folder: give the name of a file")
