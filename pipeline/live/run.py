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
from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.frame_budget import Budget
from makeup_video.pipeline.live.interfaces import LivePicture, LiveSink, LiveSource
from makeup_video.pipeline.live.runner import LiveRunner
from makeup_video.pipeline.live.warm_up import warm_up
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.smoothing.realtime import SmoothLive

_FIGURES_SECONDS = 2.0  # what the figures look back on
_REPEAT_SECONDS = 60.0  # before the same line is said again
# a frame, and monotonic seconds: its work began, faces, smooth, scene and composite ended
Observe = Callable[[Frame, tuple[float, float, float, float, float]], None]
_ALL_IS_WELL = "fast enough again: nothing is left out"


@dataclass(frozen=True, slots=True)
class SinkFigures:
    """name: as the sink calls itself.  pictures, dropped: since the beginning; pictures: those
    that the sink has written, sent or shown.
    """

    name: str
    pictures: int
    dropped: int


@dataclass(frozen=True, slots=True)
class LiveFigures:
    """How the run is doing.

    fps: painted pictures a second, and latency_ms, latency_p95_ms: from a frame's arrival to its being
    painted, median and 95th percentile, all of the last seconds; None before the first picture.
    pictures, dropped: since the beginning; dropped: frames that came while one was still
    waiting, or that the camera had no time for.
    level, level_told: what a slow machine leaves out: see budget.py.  notice: what is wrong with
    the source or a sink, or "".
    """

    fps: float
    latency_ms: float | None
    latency_p95_ms: float | None
    pictures: int
    dropped: int
    level: int
    level_told: str
    notice: str
    sinks: tuple[SinkFigures, ...]


class LiveRun:
    """Paints what a camera sees, now.

    faces, device: as in Settings.  say: told in a line what happens on the way.  Attributes that
    other threads may set: `compare`: keep what the camera saw beside what is painted.
    observe: called for each frame with the times at which its stages ended.
    Raises InstallError, UsageError for the device.
    """

    def __init__(
        self,
        camera: LiveSource,
        look: Look,
        sinks: list[LiveSink],
        *,
        faces: str = "all",
        device: str = "",
        say: Callable[[str], None] = lambda line: None,
        observe: Observe | None = None,
    ) -> None:
        self.compare = False
        self._observe = observe
        self._camera = camera
        self._find = FindFaces()
        self._smooth = SmoothLive()
        self._scene = BuildScene(device, exclusive=True)  # photos are read meanwhile
        self._composite = Composite(look, device, faces)
        self._runner = LiveRunner(
            camera, self._paint, sinks, say, partial(warm_up, self._scene, self._composite)
        )
        self._budget = Budget()
        self._say = say
        self._said: dict[str, float] = {}  # what of the level, and when
        self._last: deque[tuple[float, float]] = deque()  # when painted, how late
        self._pictures = 0
        self._before = math.nan, 0  # when the last frame arrived, and how many were dropped by then

    @property
    def look(self) -> Look:
        return self._composite.look

    @property
    def painted_frames(self) -> int:
        """Frames that were painted on so far."""
        return self._composite.painted_frames

    def set_look(self, look: Look) -> None:
        """From the next frame on; from any thread."""
        self._composite.set_look(look)

    def run(self, on_tick: Callable[[], None] | None = None) -> None:
        """Block until the camera ends or the run is stopped; raises as LiveRunner.run does."""
        try:
            with one_opencv_thread(), _old_objects_left_alone():
                self._runner.run(on_tick)
        except KeyboardInterrupt:  # when the runner did not listen: the sinks are to be finished
            self._runner.stop()
            self._runner.run()

    def stop(self) -> None:
        """End the run, from any thread."""
        self._runner.stop()

    @property
    def failures(self) -> list[MakeupVideoError]:
        """Of the sinks that gave up before the end, or never worked."""
        return [each.error for each in self._runner.outlets if each.error is not None]

    def figures(self) -> LiveFigures:
        """From any thread."""
        now = time.monotonic()
        last = [each for each in tuple(self._last) if now - each[0] < _FIGURES_SECONDS]
        late_ms = sorted(1000 * late for _, late in last)
        fps = (len(last) - 1) / (last[-1][0] - last[0][0]) if len(last) > 1 else 0.0
        return LiveFigures(
            fps=fps,
            latency_ms=late_ms[len(late_ms) // 2] if late_ms else None,
            latency_p95_ms=late_ms[int(0.95 * len(late_ms))] if late_ms else None,
            pictures=self._pictures,
            dropped=self._dropped,
            level=self._budget.level,
            level_told=self._budget.told,
            notice=self._notice(),
            sinks=tuple(
                SinkFigures(each.sink.name, each.sink.sent, each.channel.dropped)
                for each in self._runner.outlets
            ),
        )

    @property
    def _dropped(self) -> int:
        return self._runner.inbox.dropped + self._camera.dropped

    def _notice(self) -> str:
        """What is wrong now with the camera, or with what a sink sends to."""
        sinks = [getattr(each.sink, "notice", "") for each in self._runner.outlets]
        gone = [f"{e.sink.name}: {e.error}" for e in self._runner.outlets if e.error is not None]
        return "; ".join(filter(None, [self._camera.notice, *sinks, *gone]))

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
        self._spend(now - began, frame.seconds)
        self._note(now, now - frame.seconds)
        return LivePicture(painted, before)

    def _spend(self, work_seconds: float, arrived_seconds: float) -> None:
        """Leave out more, or less, from the next frame on."""
        before_seconds, before_dropped = self._before
        dropped = self._dropped
        self._before = arrived_seconds, dropped
        if math.isnan(before_seconds):
            return
        told = self._budget.told
        interval = arrived_seconds - before_seconds
        level = self._budget(work_seconds, interval, dropped - before_dropped)
        self._find.level = self._composite.level = level
        if self._budget.told != told:
            self._say_now_and_then(self._budget.told or _ALL_IS_WELL, arrived_seconds)

    def _say_now_and_then(self, line: str, seconds: float) -> None:
        """On a machine with other things to do the level may come and go; the page shows it all the time."""
        if seconds - self._said.get(line, -math.inf) >= _REPEAT_SECONDS:
            self._said[line] = seconds
            self._say(line)

    def _note(self, now: float, late_seconds: float) -> None:
        self._pictures += 1
        self._last.append((now, late_seconds))
        while now - self._last[0][0] > _FIGURES_SECONDS:
            self._last.popleft()


def _copies(frame: Frame) -> tuple[np.ndarray, ...]:
    return tuple(plane.copy() for plane in frame.planes)


@contextmanager
def _old_objects_left_alone() -> Generator[None, None, None]:
    """What is loaded by now is not looked through for garbage any more: that takes 10 to 20 ms each time,
    in the middle of some frame."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
