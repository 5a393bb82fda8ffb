"""Paints a long film in segments, each a job of its own, and joins them to one output."""

import contextlib
import os
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from makeup_video.pipeline.engine.machine import cores, peak_memory_bytes
from makeup_video.pipeline.engine.processes import Processes
from makeup_video.pipeline.errors import UsageError, option
from makeup_video.pipeline.files.output_file import OutputFile, write_errors
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.media.decode import DecodeStats
from makeup_video.pipeline.media.input_file import VideoSource, local_file, open_video
from makeup_video.pipeline.media.join import Join
from makeup_video.pipeline.media.mux import Muxer
from makeup_video.pipeline.media.segments import Plan, Segment, plan_segments
from makeup_video.pipeline.offline.encoding import choose_encoding
from makeup_video.pipeline.offline.face_numbers import FaceNumbers, Sighting
from makeup_video.pipeline.offline.film import film_report, open_decoder
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.run import Progress
from makeup_video.pipeline.offline.segment_job import SegmentJob, SegmentResult, paint_segment
from makeup_video.pipeline.offline.settings import Settings


def plan_of(src: str | os.PathLike[str], look: Look, minutes: Fraction) -> Plan:
    """Where to split a film into segments of about so many minutes.

    Raises InputError, DecodeError.
    """
    source = open_video(local_file(src))
    try:
        return plan_segments(source, minutes * 60, run_up=not look.is_bare)
    finally:
        source.close()


def process_in_segments(
    src: str | os.PathLike[str],
    dst: str | os.PathLike[str],
    plan: Plan,
    look: Look,
    settings: Settings,
    on_progress: Progress | None = None,
) -> Report:
    """Paint the segments of a plan, `settings.jobs` at once, and join them as dst.

    on_progress: as in process_video.  Raises one of `errors`; dst is then unchanged, or still does
    not exist, and no segment is left.
    """
    began, cpu_began = time.monotonic(), time.process_time()
    source, output = open_video(local_file(src)), Path(dst)
    try:
        encoding = choose_encoding(source, output, settings)
        bytes_in = source.container.size
        target = OutputFile(
            output, source.path, overwrite=settings.overwrite, on_whole=settings.on_whole
        )
        muxer = Muxer(target, encoding.container, strict=settings.strict)
        try:
            decoder = open_decoder(source, encoding, muxer, settings)
            encoder = encoding.encoder(muxer, source, settings.encoder_threads)
            join = Join(decoder, encoder, muxer)
            join.begin(compare=settings.compare)
            with _folder(target, settings.overwrite) as folder:
                jobs = _jobs(folder, source.path, target.path, plan, look, settings)
                results, faces = _paint(jobs, settings, _ticker(source, on_progress))
                _count(decoder.stats, results)
                join.finish([result.file for result in results])
        except BaseException:
            if not muxer.is_finished:
                muxer.abort()
            raise
    finally:
        source.close()
    report = film_report(source, output, decoder, encoder, muxer)
    report.bytes_in = bytes_in
    _add(report, results, look, settings, faces)
    report.seconds = time.monotonic() - began
    report.cpu_seconds += time.process_time() - cpu_began
    return report


def _ticker(source: VideoSource, on_progress: Progress | None) -> Callable[[int], None]:
    def tick(done: int) -> None:
        if on_progress is not None:
            on_progress(done, source.expected_frames, source.rate)

    return tick


@contextmanager
def _folder(target: OutputFile, overwrite: bool) -> Generator[Path, None, None]:
    """A folder for the segments beside the output, which is gone when the block ends.

    While the output is open no other run has the same folder.
    """
    folder = target.path.with_name(f"{target.part.stem}.segments")
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
    for file in folder.glob("segment-[0-9][0-9][0-9][0-9][0-9]"):
        with contextlib.suppress(OSError):
            file.unlink()


def _jobs(
    folder: Path, source: Path, output: Path, plan: Plan, look: Look, settings: Settings
) -> list[SegmentJob]:
    own = replace(settings, observe=None, on_whole=None)
    following = [segment.run_up for segment in plan.segments[1:]]
    chosen = settings.faces != "all" and not look.is_bare
    return [
        SegmentJob(
            source=source.absolute(),
            output=output,
            path=(folder / _name(number)).absolute(),
            look=look,
            settings=own,
            segment=segment,
            seen_again_from=seen_again_from,
            numbers=FaceNumbers() if chosen else None,
        )
        for number, (segment, seen_again_from) in enumerate(
            zip(plan.segments, [*following, None], strict=True), 1
        )
    ]


def _paint(
    jobs: Sequence[SegmentJob], settings: Settings, on_tick: Callable[[int], None]
) -> tuple[list[SegmentResult], int]:
    """The results of all jobs, and how many faces there are in the film."""
    seen = _SeenFaces()

    def follow(job: SegmentJob, before: SegmentResult) -> SegmentJob:
        seen.add(before, job.segment)
        return replace(job, numbers=seen.numbers(), largest_id=before.largest_id)

    in_order = jobs[0].numbers is not None
    workers = settings.jobs or max(1, cores() // 2)
    processes = Processes(paint_segment, workers, follow if in_order else None)
    results = processes.run(jobs, on_tick)
    if not in_order:
        for result, job in zip(results, jobs[1:], strict=False):
            seen.add(result, job.segment)
    seen.add(results[-1])
    return results, seen.count


class _SeenFaces:
    """The faces of the segments so far, with the film's numbers. count: how many there are."""

    def __init__(self) -> None:
        self.count = 0
        self._known: dict[int, tuple[Sighting, ...]] = {}

    def numbers(self) -> FaceNumbers:
        """For the faces of the next segment."""
        return FaceNumbers(self._known, self.count)

    def add(self, result: SegmentResult, following: Segment | None = None) -> None:
        """Number the faces of the next segment; `following` is the one behind it."""
        numbers = self.numbers()
        numbers.match(result.before)
        numbers.take(result.numbers)
        self.count = numbers.next_number
        self._known.update(numbers.of(result.after))
        if following is not None:  # all that it will see again
            self._known = {
                pts: faces for pts, faces in self._known.items() if not following.is_unseen(pts)
            }


def _count(stats: DecodeStats, results: Sequence[SegmentResult]) -> None:
    """The counts of all segments, in place of those of the first frame, which was decoded twice."""
    reports = [result.report for result in results]
    stats.frames = sum(report.frames_in for report in reports)
    stats.corrupt_frames = sum(report.corrupt_frames for report in reports)
    stats.decode_errors = sum(report.decode_errors for report in reports)


def _add(
    report: Report, results: Sequence[SegmentResult], look: Look, settings: Settings, faces: int
) -> None:
    """Add the counts of all segments to the report."""
    parts = [result.report for result in results]
    report.segments = len(parts)
    report.max_pts_error_seconds = max(part.max_pts_error_seconds for part in parts)
    report.media_seconds = parts[-1].media_seconds
    report.first_packet_unix_seconds = min(
        (at for part in parts if (at := part.first_packet_unix_seconds) is not None), default=None
    )
    report.cpu_seconds = sum(part.cpu_seconds for part in parts)
    report.peak_memory_bytes = max(peak_memory_bytes(), *(p.peak_memory_bytes for p in parts))
    for part in parts:
        for name, times in part.stages.items():
            total = report.stages.setdefault(name, dict.fromkeys(times, 0))
            for key, value in times.items():
                total[key] += value
    if look.is_bare:
        return
    report.faces = faces
    report.frames_with_face = sum(part.frames_with_face or 0 for part in parts)
    report.tiny_faces = sum(part.tiny_faces for part in parts)
    report.painted_frames = sum(part.painted_frames or 0 for part in parts)
    if not report.painted_frames and report.frames_with_face:
        from makeup_video.pipeline.offline.stages import why_unpainted  # late: it loads the nets

        report.why_unpainted = why_unpainted(
            look,
            settings.faces,
            report.turn_first,
            sum(result.chosen_frames for result in results),
            set[int]().union(*(result.shown_numbers for result in results)),
        )
