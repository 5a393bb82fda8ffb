"""Paints a long video in segments, each a job of its own, and joins them to one output."""

import contextlib
import os
from collections.abc import Callable, Generator, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from makeup_video.pipeline.engine.jobs import Worker
from makeup_video.pipeline.errors import UsageError, option
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.files.output_file import OutputFile, write_errors
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.media.decode_stats import DecodeStats
from makeup_video.pipeline.media.duration import check_start
from makeup_video.pipeline.media.input_file import open_video
from makeup_video.pipeline.media.join import Join
from makeup_video.pipeline.media.segments import Plan, plan_segments
from makeup_video.pipeline.offline.paint_segments import PaintedSegments, paint_segments
from makeup_video.pipeline.offline.report import Report, RunClock
from makeup_video.pipeline.offline.segment_job import SegmentJob
from makeup_video.pipeline.offline.settings import Settings
from makeup_video.pipeline.offline.unpainted import tell_unpainted
from makeup_video.pipeline.offline.video import Progress, Video, begin_video


def plan_of(src: str | os.PathLike[str], look: Look, minutes: Fraction, settings: Settings) -> Plan:
    """Where to split a video, or the excerpt that the settings keep, into segments of about
    `minutes` minutes.

    Raises UsageError, InputError, DecodeError.
    """
    with closing(open_video(local_file(src))) as source:
        check_start(source, settings.start_seconds)
        excerpt = settings.start_seconds, settings.end_seconds
        return plan_segments(source, minutes * 60, excerpt, run_up=not look.is_bare)


def process_in_segments(
    src: str | os.PathLike[str],
    dst: str | os.PathLike[str],
    plan: Plan,
    look: Look,
    settings: Settings,
    on_progress: Progress | None,
    workers: Sequence[Worker] | None,
) -> Report:
    """Paint the segments of a plan, as many at once as there are workers, and join them as dst.

    on_progress: as in process_video.  workers: see process_video.
    Raises one of `errors`; dst is then unchanged, or still does not exist, and no segment is left.
    """
    clock = RunClock()
    with (
        closing(open_video(local_file(src))) as source,
        begin_video(source, Path(dst), settings) as video,
    ):
        join = Join(video.decoder, video.encoder, video.muxer)
        join.begin(compare=settings.compare)
        target = video.muxer.target
        with _folder(target, settings.overwrite) as folder:
            jobs = _jobs(folder, source.path, target.path, plan, look, settings)
            painted = paint_segments(jobs, settings, _ticker(video, on_progress), workers)
            _count(video.decoder.stats, painted)
            lost = [text for result in painted.results for text in result.report.dropped]
            if lost:
                video.muxer.drop(lost[0])  # later segments lose the same
            join.finish([result.file for result in painted.results])
        report = video.report()
    clock.write(report)
    _add(report, painted, look, settings)
    return report


def _ticker(video: Video, on_progress: Progress | None) -> Callable[[int], None]:
    expected, rate = video.decoder.expected_frames, video.source.rate

    def tick(done: int) -> None:
        if on_progress is not None:
            on_progress(done, expected, rate)

    return tick


@contextmanager
def _folder(target: OutputFile, overwrite: bool) -> Generator[Path, None, None]:
    """A folder for the segments, beside the output; removed when the block ends.

    The folder is named after the part, which is locked, so no other run has the same folder while
    the output is open.
    """
    folder = target.path.with_name(f"{target.part.name}.segments")
    with write_errors(folder):
        try:
            folder.mkdir()
        except FileExistsError:
            if not overwrite:
                raise UsageError(
                    f"{folder} exists, perhaps from a run that was stopped: add "
                    f"{option('overwrite', True)} to overwrite it"
                ) from None
            _empty(folder)
    try:
        yield folder
    finally:
        _empty(folder)
        with contextlib.suppress(OSError):  # a file of somebody else's is in it
            folder.rmdir()


def _name(number: int) -> str:
    return f"segment-{number:05}"


def _empty(folder: Path) -> None:
    """Remove the segments in a folder."""
    for file in folder.glob("segment-[0-9][0-9][0-9][0-9][0-9]*"):
        with contextlib.suppress(OSError):
            file.unlink()


def _jobs(
    folder: Path, source: Path, output: Path, plan: Plan, look: Look, settings: Settings
) -> list[SegmentJob]:
    own = replace(settings, observe=None, on_whole=None, overwrite=True)
    following = [segment.run_up for segment in plan.segments[1:]]
    return [
        SegmentJob(
            source=source.absolute(),
            output=output,
            path=(folder / _name(number)).absolute(),
            look=look,
            settings=own,
            segment=segment,
            seen_again_from=seen_again_from,
        )
        for number, (segment, seen_again_from) in enumerate(
            zip(plan.segments, [*following, None], strict=True), 1
        )
    ]


def _count(stats: DecodeStats, painted: PaintedSegments) -> None:
    """Put the counts of all segments in place of the first frame's, which was decoded twice."""
    reports = [result.report for result in painted.results]
    stats.frames = sum(report.frames_in for report in reports)
    stats.corrupt_frames = sum(report.corrupt_frames for report in reports)
    stats.decode_errors = sum(report.decode_errors for report in reports)


def _add(report: Report, painted: PaintedSegments, look: Look, settings: Settings) -> None:
    """Add the counts, times and memory of all segments to the report."""
    parts = [result.report for result in painted.results]
    report.segments = len(parts)
    report.max_pts_error_seconds = max(part.max_pts_error_seconds for part in parts)
    (begin, _), (_, end) = painted.results[0].span, painted.results[-1].span
    report.media_seconds = float(end - begin)
    report.first_packet_unix_seconds = min(
        (at for part in parts if (at := part.first_packet_unix_seconds) is not None), default=None
    )
    report.cpu_seconds += painted.cpu_seconds
    report.peak_memory_bytes = max(one.peak_memory_bytes for one in (report, *parts))
    for part in parts:
        for name, times in part.stages.items():
            total = report.stages.setdefault(name, dict.fromkeys(times, 0))
            for key, value in times.items():
                total[key] += value
    if look.is_bare:
        return
    report.faces = painted.faces
    report.frames_with_face = sum(part.frames_with_face or 0 for part in parts)
    report.tiny_faces = sum(part.tiny_faces for part in parts)
    report.painted_frames = sum(part.painted_frames or 0 for part in parts)
    tell_unpainted(
        report,
        look,
        settings.faces,
        sum(result.chosen_frames for result in painted.results),
        painted.shown_numbers,
        {part for result in painted.results for part in result.painted_areas},
    )
