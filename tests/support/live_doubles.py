"""Sources and sinks of a live run that a test controls."""

import threading
import time

import av
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE


def frame(number):
    return Frame(av.VideoFrame(16, 16, "yuv420p"), number, LIVE_TIME_BASE, ColourTags())


def numbers(pictures):
    return [picture.frame.pts for picture in pictures]


class List:
    """A sink that keeps its pictures; `gate` can stall it, and `error` makes it fail."""

    notice = state = ""
    kind, seconds = "recording", 0.0

    def __init__(self, name="list", waiting=1, gate=None, error=None):
        self.name, self.waiting = name, waiting
        self.gate, self.error = gate, error
        self.pictures, self.is_finished = [], False

    @property
    def sent(self):
        return len(self.pictures)

    def __call__(self, picture):
        if self.gate:
            self.gate.wait(20)
        if self.error:
            raise self.error
        self.pictures.append(picture)

    def finish(self):
        self.is_finished = True


class Frames:
    """A camera that yields the frames of a generator."""

    def __init__(self, frames):
        self._frames, self.closes = frames, 0

    def frames(self):
        return self._frames

    def close(self):
        self.closes += 1


class Camera:
    """Gives a frame for each permission of the test; a stuck camera ignores `close`."""

    def __init__(self):
        self.allowed, self.given, self.closed = threading.Semaphore(0), 0, threading.Event()
        self.is_stuck = False

    def close(self):
        if not self.is_stuck:
            self.allowed.release()

    def frames(self):
        try:
            while True:
                self.allowed.acquire()
                self.given += 1
                yield frame(self.given)
        finally:
            self.closed.set()


def started(runner):
    """The run on its own thread, and the errors it raised."""
    raised = []

    def run():
        try:
            runner.run(tick_seconds=0.01)
            raised.append(None)
        except BaseException as error:  # noqa: BLE001  # the test inspects the error
            raised.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    return thread, raised


def until(condition):
    end = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.005)


def our_threads():
    return [t.name for t in threading.enumerate() if t.name.startswith("makeup-")]
