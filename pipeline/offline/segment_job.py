"""Paints one segment of a video: a job that any process on any machine can do."""

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, cast

from makeup_video.pipeline.engine.machine import (
    COPY_VIDEO,
    FIND_FACES,
    check_memory,
    give_back_last_run,
    one_opencv_thread,
)
from makeup_video.pipeline.engine.runner import Runner, Stage
from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.media.decode import Decoder
from makeup_video.pipeline.media.input_file import VideoSource, open_video
from makeup_video.pipeline.media.join import first_frame
from makeup_video.pipeline.media.segment_file import SegmentFile, SegmentWriter
from makeup_video.pipeline.media.segment_trim import SegmentTrim
from makeup_video.pipeline.media.segments import Segment
from makeup_video.pipeline.offline.encoding import Encoding, choose_encoding, decoder_threads
from makeup_video.pipeline.offline.face_numbers import KnownFaces, Sightings
from makeup_video.pipeline.offline.report import Report, RunClock
from makeup_video.pipeline.offline.run import compared
from makeup_video.pipeline.offline.settings import Settings
from makeup_video.pipeline.offline.video import channel_frames, open_decoder


@dataclass(frozen=True, slots=True)
class SegmentJob:
    """All that a process needs to know to paint a segment; it can be pickled.

    source: the video.  output: the file in which the segments are joined.
    path: where to write the painted segment.
    settings: of the whole run, without functions.
    seen_again_from: time, in ticks of the source, from which the next segment sees the frames, too.
    known: what earlier segments say about its faces; None: the segment uses its own numbers.
    """

    source: Path
    output: Path
    path: Path
    look: Look
    settings: Settings
    segment: Segment
    seen_again_from: int | None = None
    known: KnownFaces | None = None

    @property
    def outputs(self) -> tuple[str, ...]:
        """The one file that is written, by a name that every process knows."""
        return (str(self.path),)

    def at_full_paths(self) -> "SegmentJob":
        return self

    def again(self) -> "SegmentJob":
        """The same job for another machine: into another file, since the lost machine may still
        write."""
        return replace(self, path=self.path.with_name(f"{self.path.name}-again"))

    def moved(self, source: str, outputs: Sequence[str]) -> "SegmentJob":
        """The same job on other files."""
        (path,) = outputs
        return replace(self, source=Path(source), path=Path(path))

    def brought_back(self, result: "SegmentResult") -> "tuple[SegmentResult, list[int]]":
        """(the result, as if this job had written its own files; the places of whole outputs).

        result: of this job `at_full_paths` or as `moved`.
        """
        return replace(result, file=replace(result.file, path=self.path)), [0]

    def without(self, result: "SegmentResult", at: int, error: MakeupVideoError) -> "SegmentResult":
        """Raises the error: nothing is left of a segment whose file could not be kept."""
        raise error


@dataclass(frozen=True, slots=True)
class SegmentResult:
    """A painted segment, and what was counted; it can be pickled.

    span: when its first frame begins and its last one ends, in seconds of the video.
    before, after, numbers: as in SegmentFaces.  chosen_frames, painted_areas: as in Composite.
    largest_first, largest_id: the largest face when the segment began, and the one that was painted
    last as the largest.
    Faces have the segment's own numbers. Only largest_first and largest_id are the video's numbers
    where the job knew them.
    """

    file: SegmentFile
    report: Report
    span: tuple[Fraction, Fraction]
    before: Sightings = field(default_factory=dict)
    after: Sightings = field(default_factory=dict)
    numbers: tuple[int, ...] = ()
    chosen_frames: int = 0
    painted_areas: tuple[str, ...] = ()
    largest_first: int | None = None
    largest_id: int | None = None


def paint_segment(job: SegmentJob, on_tick: Callable[[int], None]) -> SegmentResult:
    """Paint a segment and write it to `job.path`.

    on_tick(frames done) is called a few times a second.  Raises one of `errors`; there is then no
    file at `job.path`.
    """
    clock = RunClock()
    with closing(open_video(job.source)) as source:
        encoding = choose_encoding(source, job.output, job.settings)
        writer = SegmentWriter(job.path, encoding.container)
        try:
            with one_opencv_thread():
                result = _painted(job, source, encoding, writer, on_tick)
        except BaseException:
            writer.abort()
            raise
    clock.write(result.report)
    give_back_last_run()
    return result


def _painted(
    job: SegmentJob,
    source: VideoSource,
    encoding: Encoding,
    writer: SegmentWriter,
    on_tick: Callable[[int], None],
) -> SegmentResult:
    painting = _Painting(job, source)
    convert = encoding.convert()
    threads = decoder_threads(job.settings.decoder_threads)
    # the video's first frame opens the encoder of every segment: see first_frame
    with closing(open_video(job.source)) as opening:
        encoder = encoding.encoder(writer, opening, job.settings.encoder_threads)
        with closing(open_decoder(opening, encoding, writer, job.settings)) as begin:
            encoder.open(first_frame(begin, compare=job.settings.compare))
    trim = SegmentTrim(job.segment, painting.ahead_frames, source.time_base)
    decoder = Decoder(source, convert, writer, segment=trim, threads=threads)
    runner = Runner(
        ("decode", decoder.frames()),
        painting.stages,
        ("encode", encoder),
        channel_frames(source),
        threads=job.settings.stage_threads,
    )
    runner.run(on_tick)
    report = Report(
        source=str(job.source),
        output=str(job.path),
        codec=encoding.codec.name,
        encoder=encoding.codec.encoder,
        frames_in=runner.times["encode"].items,
        frames_out=writer.video_packets,
        max_pts_error_seconds=float(encoder.max_pts_error_seconds),
        corrupt_frames=decoder.stats.corrupt_frames,
        decode_errors=decoder.stats.decode_errors,
        dropped=writer.later,
        first_packet_unix_seconds=encoder.first_packet_at,
        stages={name: asdict(times) for name, times in runner.times.items()},
    )
    return painting.result(writer.file(encoder.headers), report, encoder.span)


class _Painting:
    """The stages of one segment, and what they counted.

    ahead_frames: how many frames after the segment the smoothing needs.
    """

    def __init__(self, job: SegmentJob, source: VideoSource) -> None:
        self.stages: list[tuple[str, Stage]] = []
        self.ahead_frames = 0
        self._faces: Any = None
        if job.look.is_bare:
            check_memory(COPY_VIDEO, source.frame_px)
            if job.settings.compare:
                self.stages = compared([])
        else:
            check_memory(FIND_FACES)
            self._find_and_paint(job, source)

    def _find_and_paint(self, job: SegmentJob, source: VideoSource) -> None:
        # late, as in process_video: only painting needs the face nets and OpenCL
        from makeup_video.pipeline.offline.segment_stages import (
            FromBeginning,
            SegmentFaces,
            UntilEnd,
        )
        from makeup_video.pipeline.offline.stages import PaintRun
        from makeup_video.pipeline.smoothing.lookahead import AHEAD_FRAMES

        run = PaintRun(job.look, job.settings.faces, job.settings.device)
        steps = run(source)
        find, smooth, scene, _ = (cast(Any, stage) for _, stage in steps)
        painter = (compared(steps) if job.settings.compare else steps)[-1][1]
        self._composite = run.composite
        self._painter = FromBeginning(job.segment, self._composite, painter, job.known)
        self._faces = SegmentFaces(find, job.segment, job.seen_again_from)
        self.ahead_frames = AHEAD_FRAMES
        self.stages = [
            ("faces", self._faces),
            ("smooth", smooth),
            ("scene", UntilEnd(job.segment, scene)),
            ("composite", self._painter),
        ]

    def result(
        self, file: SegmentFile, report: Report, span: tuple[Fraction, Fraction]
    ) -> SegmentResult:
        """The result of a job; the counts of faces are written into the report."""
        faces = self._faces
        if faces is None:
            return SegmentResult(file, report, span)
        composite = self._composite
        report.frames_with_face, report.tiny_faces = faces.frames_with_face, faces.tiny_faces
        report.painted_frames = composite.painted_frames
        return SegmentResult(
            file,
            report,
            span,
            faces.before,
            faces.after,
            tuple(faces.numbers),
            composite.chosen_frames,
            tuple(sorted(composite.painted_areas)),
            self._painter.largest_first,
            composite.largest_id,
        )
