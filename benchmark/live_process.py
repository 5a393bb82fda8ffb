"""A live run that is measured, in a process of its own: the parts of `makeup-video live` with a file as
camera, the page's server, and one viewer.

    python -m makeup_video.benchmark.live_process FILM LOOK.json FOLDER

Leaves frames.npy, samples.npy and viewed.npy in the folder, and says on stdout what else there is to know (JSON).
"""

import json
import math
import subprocess
import sys
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import wraps
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from makeup_video.benchmark.live import COLUMNS, SAMPLES
from makeup_video.pipeline import Look, OutputError, StoppedError
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.images.jpeg import PreviewJpeg
from makeup_video.pipeline.live.run import LiveRun
from makeup_video.pipeline.live.sources.camera import Camera, CameraSettings
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.smoothing.realtime import SmoothLive
from makeup_video.web.live_session import LiveShow
from makeup_video.web.preview_sink import PreviewSink
from makeup_video.web.server import Server
from makeup_video.web.worker import Worker

_STAGES = {"faces": FindFaces, "smooth": SmoothLive, "scene": BuildScene, "composite": Composite}
_MOST_FRAMES = 60 * 60 * 60  # an hour at 60 frames/s
_IN_HAND = 100  # so many frames are told apart at a time; far fewer are on their way


class Log:
    """When each frame came and went: a table that is there from the beginning, or memory would seem to grow.

    Every column is written by one thread.
    """

    def __init__(self, frames: int) -> None:
        self._table = np.full((frames, len(COLUMNS)), np.nan)
        self._count, self._worked_on = 0, 0
        self._row_of: dict[int, int] = {}

    def coming(self, frames: Callable[[Camera], Iterable[Frame]]) -> Callable[..., Iterator[Frame]]:
        """The same frames, noted as they come."""

        def noted(camera: Camera) -> Iterator[Frame]:
            for frame in frames(camera):
                self._came(frame)
                yield frame
                del frame

        return noted

    def timed(self, name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        """The same method, its time noted with the frame that is painted now."""
        begin, end = COLUMNS.index(f"{name} begins"), COLUMNS.index(f"{name} ends")

        @wraps(call)
        def noted(stage: Any, item: Any) -> Any:
            if name == "work":
                self._worked_on = self._row_of[item.pts]
            row = self._row_of[item.frame.pts] if name == "preview" else self._worked_on
            self._table[row, begin] = time.monotonic()
            made = call(stage, item)
            self._table[row, end] = time.monotonic()
            return made

        return noted

    def _came(self, frame: Frame) -> None:
        row = min(self._count, len(self._table) - 1)
        if len(self._row_of) >= _IN_HAND:
            del self._row_of[next(iter(self._row_of))]
        self._row_of[frame.pts] = row
        self._table[row, :2] = frame.pts, time.monotonic()
        self._count = row + 1

    def save(self, target: Path) -> None:
        np.save(target, self._table[: self._count])


def run(film: Path, look: Look, folder: Path) -> dict[str, Any]:
    """Play the film once, from beginning to end."""
    camera = Camera(CameraSettings(name=str(film)), say=_say)
    log = Log(_frames_of(film))
    with _noted(log):
        sink = PreviewSink(PreviewJpeg())
        live = LiveRun(camera, look, [sink], say=_say)
        samples: list[list[float]] = []

        def on_tick() -> None:
            samples.append([time.monotonic(), *_memory_and_cpu()])

        with _watched(LiveShow(live, sink), folder):
            on_tick()
            with suppress(StoppedError):  # Ctrl-C: what there is counts
                live.run(on_tick)
            on_tick()
    log.save(folder / "frames.npy")
    np.save(folder / SAMPLES, np.array(samples))
    done = live.figures()
    return {
        "level": done.level,
        "painted_share": live._composite.painted_frames / max(done.pictures, 1),
    }


@contextmanager
def _noted(log: Log) -> Generator[None, None, None]:
    methods = [("work", LiveRun, "_paint"), ("preview", PreviewSink, "__call__")]
    methods += [(name, stage, "__call__") for name, stage in _STAGES.items()]
    with ExitStack() as stack:
        stack.enter_context(patch.object(Camera, "frames", log.coming(Camera.frames)))
        for name, owner, method in methods:
            stack.enter_context(
                patch.object(owner, method, log.timed(name, getattr(owner, method)))
            )
        yield


@contextmanager
def _watched(show: LiveShow, folder: Path) -> Generator[None, None, None]:
    """One viewer watches meanwhile."""
    worker = Worker()
    server = Server(show, worker, port=0, say=_say)
    address = server.start().rstrip("/")
    command = [sys.executable, "-m", "makeup_video.benchmark.live_viewer"]
    command += [address.replace("http", "ws", 1) + "/ws?session=live", address]
    viewer = subprocess.Popen([*command, str(folder / "viewed.npy")], stdout=subprocess.PIPE)
    try:
        assert viewer.stdout is not None
        if not viewer.stdout.readline():
            raise OutputError(f"{address}/ shows no pictures to a viewer: try makeup-video live")
        yield
        time.sleep(0.2)  # the last pictures are on their way
    finally:
        server.stop()
        try:
            viewer.wait(10)
        except subprocess.TimeoutExpired:
            viewer.kill()


def _memory_and_cpu() -> tuple[float, float]:
    """MB in memory (NaN where the system does not tell), and CPU seconds so far."""
    from makeup_video.benchmark.runs import memory_mb

    held_mb = memory_mb("self")
    return math.nan if held_mb is None else held_mb, time.process_time()


def _frames_of(film: Path) -> int:
    import av

    with av.open(str(film)) as box:
        return min(box.streams.video[0].frames or _MOST_FRAMES, _MOST_FRAMES)


def _say(line: str) -> None:
    print(line, file=sys.stderr)


if __name__ == "__main__":
    played = run(Path(sys.argv[1]), Look.load(sys.argv[2]), Path(sys.argv[3]))
    print(json.dumps(played))
