"""Paints several looks on one video, which is decoded and searched for faces only once."""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

from makeup_video.pipeline.engine.fan_out import FanOut
from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.engine.runner import Runner, Stage, StageTimes, Stopwatch
from makeup_video.pipeline.engine.split_evenly import split_evenly
from makeup_video.pipeline.errors import MakeupVideoError, StoppedError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.media.encode import VideoEncoder
from makeup_video.pipeline.media.for_each_output import CopyFrames, CopyToAll
from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.media.mux import Muxer
from makeup_video.pipeline.media.side_by_side import SideBySide
from makeup_video.pipeline.offline.encoding import choose_encoding
from makeup_video.pipeline.offline.report import Outcome, Report
from makeup_video.pipeline.offline.settings import Settings
from makeup_video.pipeline.offline.stages import FaceRun, Stages, count_painted
from makeup_video.pipeline.offline.video import (
    Progress,
    add_times,
    channel_frames,
    open_decoder,
    open_muxer,
    video_report,
)
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite, open_canvas
from makeup_video.pipeline.render.scene import FrameScene


class PaintAndEncode:
    """The sink of one look: FrameScene -> the output's next frame.

    times: as in Runner, of painting and of encoding.
    """

    def __init__(self, paint: Stage, encoder: VideoEncoder) -> None:
        self.encoder, self._paint = encoder, paint
        self.times = {"composite": StageTimes(), "encode": StageTimes()}
        self._painting, self._encoding = map(Stopwatch, self.times.values())

    def __call__(self, item: FrameScene) -> None:
        with self._painting:
            frame = self._paint(item)
        self._painting.times.items += 1
        with self._encoding:
            self.encoder(frame)
        self._encoding.times.items += 1

    def finish(self, stopped: bool) -> None:
        with self._encoding:
            self.encoder.finish(stopped)


def paint_video(
    source: VideoSource,
    looks: Mapping[Path, Look],
    settings: Settings,
    on_progress: Progress | None = None,
    more: bool = False,
) -> dict[Path, Outcome]:
    """Paint every look on the video, each with an encoder of its own; see process_looks.

    looks: by output, one or more; all outputs have the same extension.  more: other looks follow,
    so a Ctrl-C while these outputs are finished is not too late, and raises StoppedError.
    """
    run = _Run(looks, settings)
    stages = run.faces(source)
    run.open(source)
    runner = run.runner(source, stages)
    expected = run.decoder.expected_frames
    try:
        with closing(run.decoder):
            runner.run(on_progress and (lambda done: on_progress(done, expected, source.rate)))
    except BaseException:
        run.fan.cancel()
        run.remove_parts()
        if not all(run.fan.errors):
            raise
    run.remove_parts()
    if runner.stopped and more:
        raise StoppedError
    return run.outcomes(source, runner)


class _Run:
    """The parts of one run: a painter, an encoder and an output for each look."""

    def __init__(self, looks: Mapping[Path, Look], settings: Settings) -> None:
        self._looks, self._settings = looks, settings
        self._groups = split_evenly(len(looks), cores())
        self._composites: list[Composite | None] = []  # None for a bare look
        self._muxers: list[Muxer] = []
        self.faces = FaceRun(self._scene, paints=True)

    def _scene(self) -> Stages:
        """Called once the input is open: loads the kernels."""
        looks, settings = list(self._looks.values()), self._settings
        for group in self._groups:
            canvas = open_canvas(settings.device)  # one for each thread that paints
            for look in looks[group.start : group.stop]:
                composite = None if look.is_bare else Composite(look, canvas, settings.faces)
                self._composites.append(composite)
        return [("scene", BuildScene(settings.device))]

    def open(self, source: VideoSource) -> None:
        """Begin the outputs. Raises UsageError, OutputError; then no output is begun."""
        settings = self._settings
        encoding = choose_encoding(source, next(iter(self._looks)), settings)
        try:
            for path in self._looks:
                self._muxers.append(open_muxer(source, path, encoding, settings))
            self.sinks = [
                PaintAndEncode(
                    self._paint(composite),
                    encoding.encoder(muxer, source, settings.encoder_threads),
                )
                for composite, muxer in zip(self._composites, self._muxers, strict=True)
            ]
            copy = CopyFrames(len(self.sinks))

            def share(item: FrameScene) -> list[FrameScene]:
                return [replace(item, frame=one) for one in copy(item.frame)]

            groups = [self.sinks[group.start : group.stop] for group in self._groups]
            muxers = self._muxers  # a lambda that held `self` would keep the video in memory
            # aborted at once: on a full disk the other outputs need the space of the failed one
            self.fan = FanOut(groups, share, lambda at: muxers[at].abort())
            copier = CopyToAll(muxers, self.fan.errors)
            self.decoder = open_decoder(source, encoding, copier, settings)
        except BaseException:
            self.remove_parts()
            raise

    def _paint(self, composite: Composite | None) -> Stage:
        paint: Stage = composite or _untouched
        return SideBySide(paint) if self._settings.compare else paint

    def runner(self, source: VideoSource, stages: Stages) -> Runner:
        settings, decode = self._settings, ("decode", self.decoder.frames())
        return Runner(
            decode,
            stages,
            ("outputs", self.fan),
            channel_frames(source),
            observe=settings.observe,
            threads=settings.stage_threads,
        )

    def remove_parts(self) -> None:
        """Remove every output that is begun and not finished. Never raises."""
        for muxer in self._muxers:
            if not muxer.is_finished:
                muxer.abort()

    def outcomes(self, source: VideoSource, runner: Runner) -> dict[Path, Outcome]:
        """Each output's report, or the error that ended it. Raises errors that are not ours."""
        done: dict[Path, Outcome] = {}
        for at, (path, error) in enumerate(zip(self._looks, self.fan.errors, strict=True)):
            if error is None:
                done[path] = self._report(at, path, source, runner)
            elif isinstance(error, MakeupVideoError):
                done[path] = error
            else:
                raise error
        return done

    def _report(self, at: int, path: Path, source: VideoSource, runner: Runner) -> Report:
        sink, composite = self.sinks[at], self._composites[at]
        times = {name: one for name, one in runner.times.items() if name != "outputs"}
        report = video_report(source, path, self.decoder, sink.encoder, self._muxers[at])
        add_times(report, times | sink.times, runner.channels)
        if composite is not None:
            self.faces.count(report)
            count_painted(composite, report)
        return report


def _untouched(item: Any) -> Frame:
    """The stage of a bare look."""
    frame: Frame = item.frame
    return frame
