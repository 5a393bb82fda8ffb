"""The threads of a live run: one for the camera, one for the work, one for each sink.

A sender never waits for the next thread: a full channel between two threads drops its oldest item.
"""

import threading
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial

from makeup_video.pipeline.engine.channel import ChannelClosed, NewestChannel
from makeup_video.pipeline.engine.signals import interrupted_later, undisturbed
from makeup_video.pipeline.errors import MakeupVideoError, StoppedError, UsageError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.interfaces import LivePicture, LiveSink, LiveSource

# A stream whose receiver is gone must not delay the end of the run; a recording is complete long
# before this.
_FINISH_SECONDS = 10.0
# How long the end waits for the camera's thread. The thread may hang in a device that is gone, so
# the wait has a limit. But the thread also loads nets and compiles kernels, and those crash when
# the process ends meanwhile.
_CAMERA_SECONDS = 3.0
_CAMERA = "camera"


@dataclass(slots=True, eq=False)
class Outlet:
    """A sink and the pictures that wait for it.

    error: why the sink ended before the run did, or never worked; else None.
    is_over: the sink takes no more pictures.
    """

    sink: LiveSink
    channel: NewestChannel[LivePicture]
    error: MakeupVideoError | None = None
    is_over: bool = False


def _outlet(sink: LiveSink) -> Outlet:
    return Outlet(sink, NewestChannel(f"-> {sink.name}", sink.waiting))


class LiveRunner:
    """Runs camera -> work -> sinks until the camera ends, `stop` is called, Ctrl-C, or an error.

    work: Frame -> LivePicture, always called on the same thread.
    log: called with a line of text when a sink gives up; the other sinks go on.
    prepare: called on the camera's thread before the first frame is fetched.
    """

    def __init__(
        self,
        camera: LiveSource,
        work: Callable[[Frame], LivePicture],
        sinks: list[LiveSink],
        log: Callable[[str], None],
        prepare: Callable[[], None] = lambda: None,
    ) -> None:
        self._camera, self._work, self._log, self._prepare = camera, work, log, prepare
        self.inbox: NewestChannel[Frame] = NewestChannel("-> work")
        self.outlets = [_outlet(sink) for sink in sinks]
        self.stopped = False
        self._has_begun = False
        self._takes_sinks = True
        self._others: set[str] = set()
        self._first_error: BaseException | None = None
        self._ended = threading.Condition()
        self._running: set[str] = set()

    def run(self, on_tick: Callable[[], None] | None = None, tick_seconds: float = 0.5) -> None:
        """Block until the run is over, and call `on_tick` every `tick_seconds` meanwhile.

        After an interrupt `run` may be called again to continue the same run.
        Raises the first error of camera or work, or of the sink whose failure leaves no sink.
        Raises StoppedError after Ctrl-C or `stop`, once every sink has finished.
        """
        try:
            with interrupted_later():
                self._start()
            while not self._wait(tick_seconds, self._others):
                if on_tick:
                    on_tick()
                if self.stopped or self._first_error is not None:
                    break  # the waits below have a limit
        except BaseException as error:  # noqa: BLE001  # even of `on_tick`; raised below
            self.stop()
            if not isinstance(error, KeyboardInterrupt):
                self._fail(error)
        with undisturbed():
            if not self._wait(_FINISH_SECONDS, self._others):
                self._log("an output did not finish in time and is abandoned")
            self._camera.close()
            self._wait(_CAMERA_SECONDS, {_CAMERA})
        if self._first_error is not None:
            raise self._first_error
        if self.stopped:
            raise StoppedError

    def stop(self) -> None:
        """End the run: waiting frames are dropped, and the sinks finish. From any thread."""
        self.stopped = True
        self.inbox.cancel()
        self._camera.close()

    def add(self, sink: LiveSink) -> None:
        """Start a further sink, from any thread. Raises UsageError before or after the run."""
        outlet = _outlet(sink)
        with self._ended:
            if "paint" not in self._running or self.stopped or not self._takes_sinks:
                raise UsageError("no live run is going on")
            name = f"sink {len(self.outlets)}"
            # a new list, since other threads iterate over the old one
            self.outlets = [*self.outlets, outlet]
            self._others.add(name)
            self._running.add(name)
        try:
            self._start_thread(name, partial(self._run_sink, outlet))
        except RuntimeError:  # the system has no thread left: `run` must not wait for this sink
            outlet.is_over = True
            with self._ended:
                self._running.discard(name)
                self._others.discard(name)
            raise

    def end(self, sink: LiveSink) -> None:
        """Let a sink finish the pictures that wait for it; the run goes on. From any thread."""
        for outlet in self.outlets:
            if outlet.sink is sink:
                outlet.is_over = True
                outlet.channel.close()

    def _start(self) -> None:
        if self._has_begun:
            return
        self._has_begun = True
        jobs: list[tuple[str, Callable[[], None]]] = [("paint", self._run_work)]
        jobs += [(f"sink {at}", partial(self._run_sink, o)) for at, o in enumerate(self.outlets)]
        self._others = {name for name, _ in jobs}
        self._running = {_CAMERA, *self._others}
        for name, job in [(_CAMERA, self._run_camera), *jobs]:
            self._start_thread(name, job)

    def _start_thread(self, name: str, job: Callable[[], None]) -> None:
        """Start a daemon thread, which never keeps the process from ending."""
        threading.Thread(
            target=self._guard, args=(name, job), name=f"makeup-{name}", daemon=True
        ).start()

    def _wait(self, seconds: float, names: set[str]) -> bool:
        """Wait at most so long; True once the named threads have ended.

        engine/runner.py tells why this does not use Thread.join.
        """
        with self._ended:
            return self._ended.wait_for(lambda: not self._running & names, seconds)

    def _guard(self, name: str, job: Callable[[], None]) -> None:
        try:
            job()
        except ChannelClosed:
            pass  # the run is over, and its error is already stored
        except BaseException as error:  # noqa: BLE001  # `run` raises it again
            self._fail(error)
        finally:
            with self._ended:
                self._running.discard(name)
                self._ended.notify_all()

    def _fail(self, error: BaseException) -> None:
        with self._ended:
            if self._first_error is None:
                self._first_error = error
        self.inbox.cancel()

    def _run_camera(self) -> None:
        if not self.stopped:
            self._prepare()
        with closing(self._camera.frames()) as frames:
            for frame in frames:
                self.inbox.send(frame)
                del frame
        self.inbox.close()

    def _run_work(self) -> None:
        try:
            for frame in self.inbox:
                self._hand_out(self._work(frame))
                del frame
        finally:
            with self._ended:  # a sink that was added now would wait for pictures for ever
                self._takes_sinks = False
            for outlet in self.outlets:
                outlet.channel.close()

    def _hand_out(self, picture: LivePicture) -> None:
        working = [outlet for outlet in self.outlets if outlet.error is None]
        if self.outlets and not working:
            raise ChannelClosed("no output takes frames any more")
        for outlet in working:
            if outlet.is_over:
                continue
            with suppress(ChannelClosed):  # the outlet's sink gave up just now
                outlet.channel.send(picture)

    def _run_sink(self, outlet: Outlet) -> None:
        finishes = False
        try:
            for picture in outlet.channel:
                outlet.sink(picture)
                del picture
            finishes = True
            outlet.sink.finish()
            outlet.is_over = True
        except MakeupVideoError as error:
            outlet.error, outlet.is_over = error, True
            outlet.channel.cancel()  # free the pictures that wait
            # an output that ended well takes no more pictures, but keeps what it got
            if all(each.error or (each.is_over and not finishes) for each in self.outlets):
                self._fail(error)  # `run` raises the error, so it is not logged here
            else:
                rest = "; the rest goes on" if self._takes_sinks else ""
                self._log(f"{type(error).__name__}: {error}{rest}")
        except ChannelClosed:
            raise
        except Exception:
            outlet.is_over = True
            with suppress(Exception):
                outlet.sink.finish()  # closes its device, file or child process
            raise
