"""The threads of a live run: one for the camera, one for the work, one for each sink.

Nobody waits for anybody: between any two of them the newest picture wins, so nothing gets old.
"""

import threading
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial

from makeup_video.pipeline.engine.channel import ChannelClosed, NewestChannel
from makeup_video.pipeline.engine.signals import interrupted_later, undisturbed
from makeup_video.pipeline.errors import MakeupVideoError, StoppedError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.interfaces import LivePicture, LiveSink, LiveSource

# A stream whose other end is gone must not keep us; a recording is whole long before.
_FINISH_SECONDS = 10.0
# The camera's thread may be stuck in a device that is gone; but who ends the process while it loads
# nets or compiles kernels makes them crash.
_CAMERA_SECONDS = 3.0
_CAMERA = "camera"


@dataclass(slots=True, eq=False)
class Outlet:
    """A sink and what waits for it.

    error: why the sink ended before the run did, or never worked.
    """

    sink: LiveSink
    channel: NewestChannel[LivePicture]
    error: MakeupVideoError | None = None


class LiveRunner:
    """Runs camera -> work -> sinks until the camera ends, `stop`, Ctrl-C, or a fault.

    work: Frame -> LivePicture, always on one thread.  say: told in a line when a sink gives up;
    the others go on.  prepare: called before the first frame is asked for.  `stop` may be called
    from any thread.
    """

    def __init__(
        self,
        camera: LiveSource,
        work: Callable[[Frame], LivePicture],
        sinks: list[LiveSink],
        say: Callable[[str], None],
        prepare: Callable[[], None] = lambda: None,
    ) -> None:
        self._camera, self._work, self._say, self._prepare = camera, work, say, prepare
        self.inbox: NewestChannel[Frame] = NewestChannel("-> work")
        self.outlets = [Outlet(s, NewestChannel(f"-> {s.name}", s.waiting)) for s in sinks]
        self.stopped = False
        self._has_begun = False
        self._others: set[str] = set()
        self._first_error: BaseException | None = None
        self._ended = threading.Condition()
        self._running: set[str] = set()

    def run(self, on_tick: Callable[[], None] | None = None, tick_seconds: float = 0.5) -> None:
        """Block until all is done; `on_tick` is called meanwhile. Called again after an interrupt it goes on
        with the same run.

        Raises the first error of camera or work; the error of a sink when none is left; StoppedError
        after Ctrl-C or `stop`, once every sink has finished what it had.
        """
        try:
            with interrupted_later():
                self._start()
            while not self._wait(tick_seconds, self._others):
                if on_tick:
                    on_tick()
                if self.stopped or self._first_error is not None:
                    break  # from here on nobody is waited for without an end
        except BaseException as error:  # noqa: BLE001  # a display that fails, too; raised below
            self.stop()
            if not isinstance(error, KeyboardInterrupt):
                self._fail(error)
        with undisturbed():
            if not self._wait(_FINISH_SECONDS, self._others):
                self._say("something that was written or sent did not end in time; leaving it")
            self._camera.close()
            self._wait(_CAMERA_SECONDS, {_CAMERA})
        if self._first_error is not None:
            raise self._first_error
        if self.stopped:
            raise StoppedError("stopped by the user")

    def stop(self) -> None:
        """End the run: what waits to be painted is dropped, the sinks finish what they have."""
        self.stopped = True
        self.inbox.cancel()
        self._camera.close()

    def _start(self) -> None:
        if self._has_begun:
            return
        self._has_begun = True
        jobs: list[tuple[str, Callable[[], None]]] = [("paint", self._run_work)]
        jobs += [(f"sink {at}", partial(self._run_sink, o)) for at, o in enumerate(self.outlets)]
        self._others = {name for name, _ in jobs}
        self._running = {_CAMERA, *self._others}
        # Daemons, so that none of them keeps the process from ending.
        for name, job in [(_CAMERA, self._run_camera), *jobs]:
            threading.Thread(
                target=self._guard, args=(name, job), name=f"makeup-{name}", daemon=True
            ).start()

    def _wait(self, seconds: float, names: set[str]) -> bool:
        """True once these have ended. Not Thread.join: see runner.py."""
        with self._ended:
            return self._ended.wait_for(lambda: not self._running & names, seconds)

    def _guard(self, name: str, job: Callable[[], None]) -> None:
        try:
            job()
        except ChannelClosed:
            pass  # the run is over; whoever ended it has said why
        except BaseException as error:  # noqa: BLE001  # raised again by `run`
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
            for outlet in self.outlets:
                outlet.channel.close()

    def _hand_out(self, picture: LivePicture) -> None:
        open_ones = [each for each in self.outlets if each.error is None]
        if self.outlets and not open_ones:
            raise ChannelClosed("nobody takes the pictures any more")
        for outlet in open_ones:
            with suppress(ChannelClosed):  # its sink gave up just now
                outlet.channel.send(picture)

    def _run_sink(self, outlet: Outlet) -> None:
        goes_on = "; the rest goes on"
        try:
            for picture in outlet.channel:
                outlet.sink(picture)
                del picture
            goes_on = ""  # from here on the run is over
            outlet.sink.finish(self.stopped or self._first_error is not None)
        except MakeupVideoError as error:
            outlet.error = error
            outlet.channel.cancel()  # pictures that nobody takes any more must not stay in memory
            if all(each.error is not None for each in self.outlets):
                self._fail(error)  # told once, by whoever runs us
            else:
                self._say(f"{type(error).__name__}: {error}{goes_on}")
