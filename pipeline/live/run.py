"""Puts the live pipeline together: camera -> faces -> smooth -> scene -> composite -> sinks."""

import gc
import math
import time
from collections import deque
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import numpy as np
from makeup_video.pipeline.engine.machine import one_opencv_thread
from makeup_video.pipeline.engine.quality import QualityLevel
from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.frame_budget import Budget
from makeup_video.pipeline.live.interfaces import LivePicture, LiveSink, LiveSource
from makeup_video.pipeline.live.runner import LiveRunner, Outlet
from makeup_video.pipeline.live.warm_up import warm_up
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.smoothing.realtime import SmoothLive

_FIGURES_SECONDS = 2.0  # fps and latency are measured over this time
_REPEAT_SECONDS = 60.0  # the same line is logged again only after this time
# Called with a frame and five times in monotonic seconds: when its work began, and when the stages
# faces, smooth, scene and composite ended.
ObserveFrame = Callable[[Frame, tuple[float, float, float, float, float]], None]
_ALL_IS_WELL = "fast enough again: nothing is left out"


@dataclass(frozen=True, slots=True)
class SinkFigures:
    """How a sink of a live run is doing, counted since the run began.

    kind, seconds, state: as in LiveSink.  pictures: how many were written, sent or shown.
    is_over: the sink has ended.
    """

    name: str
    pictures: int
    dropped: int
    kind: str = ""
    seconds: float = 0.0
    state: str = ""
    is_over: bool = False


@dataclass(frozen=True, slots=True)
class LiveFigures:
    """How a live run is doing.

    fps: pictures painted per second, over the last two seconds.
    latency_ms: median time from a frame's arrival until it is painted, over the last two seconds;
    None when no picture was painted in that time.
    pictures: number of pictures painted since the run began.
    dropped: number of frames, since the run began, that the source dropped or that gave way to a
    newer one while they waited.
    damaged: number of pictures of the source, since the run began, that could not be decoded.
    level, level_notice: what a slow machine leaves out, as a QualityLevel and in words.
    notice: what is wrong with the source or a sink, "" when all is well.
    """

    fps: float
    latency_ms: float | None
    pictures: int
    dropped: int
    damaged: int
    level: QualityLevel
    level_notice: str
    notice: str
    sinks: tuple[SinkFigures, ...]


class LiveRun:
    """Paints what a camera sees, as it comes.

    faces, device: as in Settings.
    log: called with a line of text for each event during the run.
    compare: keep the camera's planes in each picture; any thread may set this attribute.
    observe: called for each frame, with the times at which its work began and its stages ended.
    Raises the errors of open_device.
    """

    def __init__(
        self,
        camera: LiveSource,
        look: Look,
        sinks: list[LiveSink],
        *,
        faces: str = "all",
        device: str = "",
        log: Callable[[str], None] = lambda line: None,
        observe: ObserveFrame | None = None,
    ) -> None:
        self.compare = False
        self._observe = observe
        self._camera = camera
        self._find = FindFaces()
        self._smooth = SmoothLive()
        # exclusive, since the page may read photos at the same time
        self._scene = BuildScene(device, exclusive=True)
        self._composite = Composite(look, device, faces)
        self._runner = LiveRunner(
            camera, self._paint, sinks, log, partial(warm_up, self._scene, self._composite)
        )
        self._past_failures: list[Outlet] = []  # recordings that failed before the newest began
        self._budget = Budget()
        self._log = log
        self._logged: dict[str, float] = {}  # notices of the budget, and when they were logged
        # of the last pictures: when each was painted, and its delay in seconds
        self._last: deque[tuple[float, float]] = deque()
        self._pictures = 0
        self._before = math.nan, 0  # arrival of the last frame, and frames dropped until then

    @property
    def look(self) -> Look:
        return self._composite.look

    @property
    def painted_frames(self) -> int:
        """Number of frames so far on which makeup was painted."""
        return self._composite.painted_frames

    def set_look(self, look: Look) -> None:
        """Paint another look from the next frame on. May be called from any thread."""
        self._composite.set_look(look)

    def add_sink(self, sink: LiveSink) -> None:
        """Hand the pictures to a further sink from now on. May be called from any thread.

        Raises UsageError when the run has not begun, or is over.
        """
        self._runner.add(sink)
        if sink.kind == "recording":  # what ended earlier ones no longer matters
            self._past_failures = [
                outlet
                for outlet in self._runner.outlets
                if outlet.error is not None and outlet.sink.kind == "recording"
            ]

    def end_sink(self, sink: LiveSink) -> None:
        """Let a sink finish the pictures that wait for it; the run goes on. From any thread."""
        self._runner.end(sink)

    def run(self, on_tick: Callable[[], None] | None = None) -> None:
        """Block until the camera ends or the run is stopped. Raises the errors of LiveRunner.run.

        on_tick: called about twice a second meanwhile.
        """
        try:
            with one_opencv_thread(), _old_objects_left_alone():
                self._runner.run(on_tick)
        except KeyboardInterrupt:  # it came before the runner could handle it: finish the sinks
            self._runner.stop()
            self._runner.run()

    def stop(self) -> None:
        """End the run, from any thread."""
        self._runner.stop()

    @property
    def failures(self) -> list[MakeupVideoError]:
        """The errors of the sinks that gave up before the end of the run, or never worked."""
        return [outlet.error for outlet in self._runner.outlets if outlet.error is not None]

    def figures(self) -> LiveFigures:
        """Measure how the run is doing. May be called from any thread."""
        now = time.monotonic()
        last = [timing for timing in tuple(self._last) if now - timing[0] < _FIGURES_SECONDS]
        late_ms = sorted(1000 * late for _, late in last)
        fps = (len(last) - 1) / (last[-1][0] - last[0][0]) if len(last) > 1 else 0.0
        return LiveFigures(
            fps=fps,
            latency_ms=late_ms[len(late_ms) // 2] if late_ms else None,
            pictures=self._pictures,
            dropped=self._dropped,
            damaged=self._camera.damaged,
            level=self._budget.level,
            level_notice=self._budget.notice,
            notice=self._notice(),
            sinks=tuple(_figures_of(outlet) for outlet in self._runner.outlets),
        )

    @property
    def _dropped(self) -> int:
        return self._runner.inbox.dropped + self._camera.dropped

    def _notice(self) -> str:
        """What is wrong now with the camera or a sink; "" when all is well."""
        outlets = self._runner.outlets
        sinks = [outlet.sink.notice for outlet in outlets]
        ended = [
            f"{o.sink.name}: {o.error}"
            for o in outlets
            if o.error is not None and o not in self._past_failures
        ]
        return "; ".join(filter(None, [self._camera.notice, *sinks, *ended]))

    def _paint(self, frame: Frame) -> LivePicture:
        began = time.monotonic()
        found = self._find(frame)
        found_at = time.monotonic()
        smoothed = self._smooth(found)
        smoothed_at = time.monotonic()
        scene = self._scene(smoothed)
        before = _copies(frame) if self.compare else None
        scene_at = time.monotonic()
        painted = self._composite(scene)
        now = time.monotonic()
        if self._observe:
            self._observe(frame, (began, found_at, smoothed_at, scene_at, now))
        self._choose_level(now - began, frame.seconds)
        self._count(now, now - frame.seconds)
        return LivePicture(painted, before)

    def _choose_level(self, work_seconds: float, arrived_seconds: float) -> None:
        """Choose what the next frame leaves out, and log a change."""
        before_seconds, before_dropped = self._before
        dropped = self._dropped
        self._before = arrived_seconds, dropped
        if math.isnan(before_seconds):
            return
        notice = self._budget.notice
        interval = arrived_seconds - before_seconds
        level = self._budget(work_seconds, interval, dropped - before_dropped)
        self._find.level = self._composite.level = level
        if self._budget.notice != notice:
            self._log_rarely(self._budget.notice or _ALL_IS_WELL, arrived_seconds)

    def _log_rarely(self, line: str, seconds: float) -> None:
        """Log a line unless it was logged a short time ago.

        On a machine with other work the level may change often. The page always shows the level.
        """
        if seconds - self._logged.get(line, -math.inf) >= _REPEAT_SECONDS:
            self._logged[line] = seconds
            self._log(line)

    def _count(self, now: float, late_seconds: float) -> None:
        self._pictures += 1
        self._last.append((now, late_seconds))
        while now - self._last[0][0] > _FIGURES_SECONDS:
            self._last.popleft()


def _figures_of(outlet: Outlet) -> SinkFigures:
    sink = outlet.sink
    return SinkFigures(
        name=sink.name,
        pictures=sink.sent,
        dropped=outlet.channel.dropped,
        kind=sink.kind,
        seconds=sink.seconds,
        state=sink.state,
        is_over=outlet.is_over,
    )


def _copies(frame: Frame) -> tuple[np.ndarray, ...]:
    return tuple(plane.copy() for plane in frame.planes)


@contextmanager
def _old_objects_left_alone() -> Generator[None, None, None]:
    """Keep the garbage collector from visiting the objects that exist now.

    Each collection would take 10 to 20 ms in the middle of a frame.
    """
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
