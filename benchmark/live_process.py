"""A measured live run in a process of its own: a file as camera, the page's server, and one viewer.

    python -m makeup_video.benchmark.live_process VIDEO LOOK.json FOLDER jpeg|h264 live_viewer

The last argument may be live_browser instead, for the page in Chromium. Writes frames.npy,
samples.npy and viewed.npy into the folder, and prints the other figures as JSON.
"""

import json
import math
import subprocess
import sys
import time
from collections.abc import Generator
from contextlib import closing, contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from makeup_video.benchmark.live import COLUMNS, FRAMES, SAMPLES, VIEWED
from makeup_video.benchmark.runs import memory_mb
from makeup_video.pipeline import Look, OutputError, StoppedError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.images.jpeg import PreviewJpeg
from makeup_video.pipeline.live.interfaces import LivePicture, LiveSource
from makeup_video.pipeline.live.preview_video import PreviewVideo
from makeup_video.pipeline.live.run import LiveRun
from makeup_video.pipeline.live.sources.camera import CameraSettings, open_source
from makeup_video.web.live_session import LiveShow
from makeup_video.web.preview_sink import PreviewSink
from makeup_video.web.server import Server
from makeup_video.web.slow_jobs import SlowJobs

_STAGES = ("faces", "smooth", "scene", "composite")
_MOST_FRAMES = 60 * 60 * 60  # an hour at 60 frames/s
_MOST_UNDER_WAY = 100  # frames whose rows are remembered; far fewer are in work at once


class FrameLog:
    """A table of the times at which each frame arrived and passed the stages.

    The table is allocated at the start: a table that grew would show as growing memory. Each column
    is written by only one thread.
    """

    def __init__(self, frames: int) -> None:
        self._table = np.full((frames, len(COLUMNS)), np.nan)
        self._count = 0
        self._row_of: dict[int, int] = {}

    def arrive(self, frame: Frame) -> None:
        """Note that a frame leaves the camera."""
        row = min(self._count, len(self._table) - 1)
        if len(self._row_of) >= _MOST_UNDER_WAY:
            del self._row_of[next(iter(self._row_of))]
        self._row_of[frame.pts] = row
        self._table[row, :2] = frame.pts, time.monotonic()
        self._count = row + 1

    def observe(self, frame: Frame, marks: tuple[float, ...]) -> None:
        """Note the times of a frame's stages. This is the observer of LiveRun."""
        self.note(frame, "work", marks[0], marks[-1])
        for name, (began, ended) in zip(_STAGES, pairwise(marks), strict=True):
            self.note(frame, name, began, ended)

    def note(self, frame: Frame, name: str, began: float, ended: float) -> None:
        """Note the monotonic seconds at which the step `name` began and ended for a frame."""
        column = COLUMNS.index(f"{name} begins")
        self._table[self._row_of[frame.pts], column : column + 2] = began, ended

    def save(self, target: Path) -> None:
        np.save(target, self._table[: self._count])


class LoggedCamera:
    """A camera whose frames are logged as they arrive; a LiveSource."""

    def __init__(self, camera: LiveSource, frame_log: FrameLog) -> None:
        self._camera, self._log = camera, frame_log

    @property
    def notice(self) -> str:
        return self._camera.notice

    @property
    def dropped(self) -> int:
        return self._camera.dropped

    @property
    def damaged(self) -> int:
        return self._camera.damaged

    def frames(self) -> Generator[Frame, None, None]:
        with closing(self._camera.frames()) as frames:
            for frame in frames:
                self._log.arrive(frame)
                yield frame
                del frame

    def close(self) -> None:
        self._camera.close()


class LoggedPreview(PreviewSink):
    """The preview sink, which logs its time for each picture."""

    def __init__(self, frame_log: FrameLog) -> None:
        super().__init__(PreviewJpeg(), PreviewVideo, _log_line)
        self._frame_log = frame_log

    def __call__(self, picture: LivePicture, /) -> None:
        began = time.monotonic()
        super().__call__(picture)
        self._frame_log.note(picture.frame, "preview", began, time.monotonic())


def run(video: Path, look: Look, folder: Path, kind: str, viewer: str) -> dict[str, Any]:
    """Play the video once, from beginning to end.

    kind: the kind of pictures, "jpeg" or "h264".  viewer: the module that watches.
    """
    frame_log = FrameLog(_count_frames(video))
    camera = LoggedCamera(open_source(CameraSettings(name=str(video)), log=_log_line), frame_log)
    sink = LoggedPreview(frame_log)
    live = LiveRun(camera, look, [sink], log=_log_line, observe=frame_log.observe)
    samples: list[list[float]] = []

    def on_tick() -> None:
        samples.append([time.monotonic(), *_memory_and_cpu()])

    with _watched(LiveShow(live, sink), folder, kind, viewer):
        on_tick()
        with suppress(StoppedError):  # after Ctrl-C the measurements so far count
            live.run(on_tick)
        on_tick()
    frame_log.save(folder / FRAMES)
    np.save(folder / SAMPLES, np.array(samples))
    figures = live.figures()
    return {
        "level": figures.level,
        "painted_share": live.painted_frames / max(figures.pictures, 1),
    }


@contextmanager
def _watched(show: LiveShow, folder: Path, kind: str, module: str) -> Generator[None, None, None]:
    """Serve the page with one viewer on it. Raises OutputError when the viewer cannot connect."""
    slow_jobs = SlowJobs()
    server = Server(show, slow_jobs, port=0, log=_log_line)
    address = server.start().rstrip("/")
    command = [sys.executable, "-m", f"makeup_video.benchmark.{module}"]
    command += [address, str(folder / VIEWED), kind]
    viewer = subprocess.Popen(command, stdout=subprocess.PIPE)
    try:
        assert viewer.stdout is not None
        if not viewer.stdout.readline():
            raise OutputError(f"{address}/ shows no pictures to a viewer: try makeup-video live")
        yield
        time.sleep(0.2)  # the last pictures are still on their way to the viewer
    finally:
        server.stop()
        try:
            viewer.wait(10)
        except subprocess.TimeoutExpired:
            viewer.kill()


def _memory_and_cpu() -> tuple[float, float]:
    """MB in memory (NaN where the system does not report it), and CPU seconds so far."""
    size_mb = memory_mb("self")
    return math.nan if size_mb is None else size_mb, time.process_time()


def _count_frames(video: Path) -> int:
    import av

    with av.open(str(video)) as container:
        return min(container.streams.video[0].frames or _MOST_FRAMES, _MOST_FRAMES)


def _log_line(line: str) -> None:
    print(line, file=sys.stderr)


if __name__ == "__main__":
    played = run(Path(sys.argv[1]), Look.load(sys.argv[2]), Path(sys.argv[3]), *sys.argv[4:])
    print(json.dumps(played))
