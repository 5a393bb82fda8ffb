"""Paints all segments of a video, with the same numbers of its faces in all of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from multiprocessing import current_process
from pathlib import Path

from makeup_video.pipeline.engine.jobs import CORES_PER_JOB, Worker, jobs_at_once, run_jobs
from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.engine.processes import ChildProcess
from makeup_video.pipeline.errors import (
    MakeupVideoError,
    TooLittleMemoryError,
    UsageError,
    WorkerError,
    option,
)
from makeup_video.pipeline.offline.face_numbers import KnownFaces, VideoNumbers
from makeup_video.pipeline.offline.segment_job import SegmentJob, SegmentResult, paint_segment
from makeup_video.pipeline.offline.settings import Settings

_ATTEMPTS = 3  # a segment whose process dies is tried twice more


@dataclass(slots=True)
class PaintedSegments:
    """The painted segments of a video.

    numbers: for each segment, the video's numbers of its faces by the segment's own numbers.
    faces: how many there are in the video.
    known: what each segment knew of its faces; None where it painted by its own numbers.
    cpu_seconds: of all processes, including those for segments that were painted twice.
    """

    results: list[SegmentResult] = field(default_factory=list)
    numbers: list[dict[int, int]] = field(default_factory=list)
    faces: int = 0
    known: list[KnownFaces | None] = field(default_factory=list)
    cpu_seconds: float = 0.0

    @property
    def shown_numbers(self) -> set[int]:
        """The video's numbers of all faces in it."""
        return {number for one in self.numbers for number in one.values()}

    def in_video(self, at: int, own: int) -> int:
        """The video's number of the face that the segment at this place calls `own`.

        Negative for a face that the segment saw in its run-up only, and that the segment before did
        not see there.
        """
        return own if self.known[at] is not None else self.numbers[at].get(own, -1 - own)

    def largest_before(self, at: int) -> int | None:
        """The video's number of the face last painted as the largest before this segment."""
        for before in reversed(range(at)):
            if (own := self.results[before].largest_id) is not None:
                return self.in_video(before, own)
        return None


def paint_segments(
    jobs: Sequence[SegmentJob],
    settings: Settings,
    on_tick: Callable[[int], None],
    workers: Sequence[Worker] | None,
) -> PaintedSegments:
    """Paint all segments, as many at once as there are workers; None: processes of this machine.

    A segment alone knows neither the video's numbers of its faces nor which face was the largest
    before. So each one is painted with what its run-up shows, and those for which this turns out
    to be wrong are painted again.
    on_tick(frames done by all jobs) is called often.  Raises the first error of any job.
    """
    if workers is None:
        if current_process().daemon:
            raise UsageError(
                "a daemonic process, such as a worker of multiprocessing.Pool, starts no others: "
                f"leave {option('split_minutes')} out here"
            )
        count = min(jobs_at_once(settings.jobs, cores() // CORES_PER_JOB), len(jobs))
        workers = [ChildProcess(_ATTEMPTS) for _ in range(count)]
    if not workers:
        raise UsageError("workers must hold at least one, or be None for processes, got none")
    run = _Run(workers, on_tick)
    painted = PaintedSegments(known=[None] * len(jobs))
    try:
        painted.results = run(jobs)
        painted.faces = _number_faces(jobs, painted)
        while wrong := _guessed_wrong(painted, settings.faces):
            again = [replace(jobs[at], known=known) for at, known in wrong.items()]
            for (at, known), result in zip(wrong.items(), run(again), strict=True):
                painted.results[at], painted.known[at] = result, known
    finally:
        for worker in workers:
            worker.stop()
    painted.cpu_seconds = run.cpu_seconds
    return painted


class _Run:
    """Paints lists of segments.  cpu_seconds: of all of them."""

    def __init__(self, workers: Sequence[Worker], on_tick: Callable[[int], None]) -> None:
        self.cpu_seconds = 0.0
        self._workers, self._on_tick = workers, on_tick
        self._frames: dict[Path, int] = {}
        self._results: dict[Path, SegmentResult] = {}

    def __call__(self, jobs: Sequence[SegmentJob]) -> list[SegmentResult]:
        run_jobs(paint_segment, jobs, self._workers, self._progress, self._end)
        return [self._results[job.path] for job in jobs]

    def _progress(self, job: SegmentJob, frames: int) -> None:
        # a segment that is tried again counts from 0, but the total that is shown never falls
        self._frames[job.path] = max(self._frames.get(job.path, 0), frames)
        self._on_tick(sum(self._frames.values()))

    def _end(self, job: SegmentJob, outcome: SegmentResult | MakeupVideoError) -> None:
        if isinstance(outcome, MakeupVideoError):
            if isinstance(outcome, WorkerError | TooLittleMemoryError):
                outcome.extend(before=f"{job.path.name} of {job.source}: ")
            raise outcome
        self.cpu_seconds += outcome.report.cpu_seconds
        self._results[job.path] = outcome
        self._progress(job, outcome.report.frames_in)


def _number_faces(jobs: Sequence[SegmentJob], painted: PaintedSegments) -> int:
    """Number the faces of all segments in order; returns how many there are."""
    numbers = VideoNumbers()
    for job, result in zip(jobs, painted.results, strict=True):
        numbers.forget_before(job.segment.is_unseen)
        painted.numbers.append(numbers.next(result.before, result.after, result.numbers))
    return numbers.count


def _guessed_wrong(painted: PaintedSegments, faces: str) -> dict[int, KnownFaces]:
    """For each segment that painted the wrong faces, by its place: what it should have known."""
    wrong = {}
    for at, numbers in enumerate(painted.numbers):
        largest = painted.largest_before(at)
        if (faces == "largest" and _differs(painted, at, largest)) or (
            faces.isdigit() and painted.known[at] is None and _is_other(numbers, int(faces))
        ):
            wrong[at] = KnownFaces(numbers, largest)
    return wrong


def _differs(painted: PaintedSegments, at: int, largest: int | None) -> bool:
    """True when a segment began with a wrong largest face, and that may matter."""
    own = painted.results[at].largest_first
    if own is None:  # no face yet: the largest one before matters only if it comes back
        return largest in painted.numbers[at].values()
    return painted.in_video(at, own) != largest


def _is_other(numbers: Mapping[int, int], chosen: int) -> bool:
    """True when this number means one face in the video and another face in the segment."""
    own = {number for number in numbers if numbers[number] == chosen}
    return own != {chosen} & set(numbers)
