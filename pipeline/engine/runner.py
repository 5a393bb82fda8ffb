"""Runs a video on threads: one for the source, some for the stages, one for the sink."""

import threading
import time
from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

from makeup_video.pipeline.engine.channel import Channel, ChannelClosed
from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.engine.signals import interrupted_later, undisturbed
from makeup_video.pipeline.engine.split_evenly import split_evenly
from makeup_video.pipeline.errors import StoppedError


class Stage(Protocol):
    """Turns one item into one item; it knows nothing of channels.

    A stage that looks ahead may return None ("not yet"). Its method `drain`, which is called once
    after the last item, then returns the items that it still holds. Items stay in order.
    """

    def __call__(self, item: Any, /) -> Any: ...


class Sink(Protocol):
    """Takes the items. `finish` is called once after the last one, also when the run is stopped."""

    def __call__(self, item: Any, /) -> None: ...
    def finish(self, stopped: bool) -> None: ...


# (an actor's name, wall seconds, CPU seconds) for one item; the sink reports `finish`, too
Observe = Callable[[str, float, float], None]


@dataclass(slots=True)
class StageTimes:
    """The cost of one actor: items, seconds at work (not waiting), CPU seconds of its thread.

    `cpu_seconds` does not include a codec's own threads.
    """

    items: int = 0
    busy_seconds: float = 0.0
    cpu_seconds: float = 0.0


_END = object()


class Stopwatch:
    """Adds the time spent within `with` to the times of one actor."""

    def __init__(
        self, times: StageTimes, observe: Callable[[float, float], None] | None = None
    ) -> None:
        self.times, self._observe = times, observe

    def __enter__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.thread_time()

    def __exit__(self, *exc: object) -> None:
        wall, cpu = time.perf_counter() - self._wall, time.thread_time() - self._cpu
        self.times.busy_seconds += wall
        self.times.cpu_seconds += cpu
        if self._observe:
            self._observe(wall, cpu)


class Runner:
    """Runs source -> stages -> sink until the end, the first error, or Ctrl-C.

    Every channel is bounded, so a slow actor makes those before it wait. The first error cancels
    every channel, and `run` raises it with its traceback; no thread is left.

    source, stages, sink: each with a name for the report.  capacity: of every channel, and so the
    most items that the stages of one thread work on in turn.
    observe: called by the actors' own threads after each item.
    threads: how many threads share the stages, neighbours together; None: one less than there are
    cores, since the codec needs one. More threads than cores only take turns, and evict each
    other's data from the cache.
    """

    def __init__(
        self,
        source: tuple[str, Generator[Any, None, None]],
        stages: list[tuple[str, Stage]],
        sink: tuple[str, Sink],
        capacity: int = 2,
        observe: Observe | None = None,
        threads: int | None = None,
    ) -> None:
        self._observe = observe
        self.source, self.stages, self.sink = source, stages, sink
        spans = split_evenly(len(stages), max(1, cores() - 1 if threads is None else threads))
        self._groups = [stages[span.start : span.stop] for span in spans]  # one for each thread
        heads = [group[0][0] for group in self._groups] + [sink[0]]
        self.channels: list[Channel[Any]] = [Channel(f"-> {name}", capacity) for name in heads]
        names = [source[0], *(name for name, _ in stages), sink[0]]
        self.times = {name: StageTimes() for name in names}
        self.stopped = False
        self._is_given_up = False
        self._is_whole = False
        self._is_finishing = False
        self._are_all_in = self._are_all_told = False  # the sink's items
        self._ticking = threading.Lock()
        self._first_error: BaseException | None = None
        self._ended = threading.Condition()
        self._running = 0

    def run(self, on_tick: Callable[[int], None] | None = None, tick_seconds: float = 0.2) -> None:
        """Block until all is done; `on_tick(items that reached the sink)` is called meanwhile, for
        the last time when all have reached it.

        Raises the first error of any actor, or StoppedError after Ctrl-C, once the sink has
        finished. A Ctrl-C while the sink is finishing a whole video has no effect. Another error of
        `on_tick` leaves the sink unfinished, so `on_tick` is not called while the sink finishes.
        """
        threads: list[threading.Thread] = []
        try:
            with interrupted_later():
                threads = self._start()
            while not self._wait(tick_seconds):
                are_all_in = self._are_all_in
                if on_tick:
                    self._tick(on_tick)
                if are_all_in:
                    self._let_finish()
        except BaseException as error:
            self._stop(error)
            with undisturbed():
                self._let_finish()
                self._wait(None)
            if not isinstance(error, KeyboardInterrupt):
                raise
        for thread in threads:
            thread.join()
        first, self._first_error = self._first_error, None
        if first is not None:
            try:
                raise first
            finally:
                del first  # its traceback refers to this frame, and so to the whole video
        if self.stopped and not self._is_whole:
            raise StoppedError

    def _tick(self, on_tick: Callable[[int], None]) -> None:
        """Call on_tick, unless the sink is finishing or an actor has failed.

        While the sink finishes, an error of on_tick would come too late to stop it. After a failure
        the actor's error counts.
        """
        with self._ticking:
            if self._is_finishing or self._first_error is not None:
                return
            try:
                on_tick(self.times[self.sink[0]].items)
            except BaseException as error:
                self._stop(error)  # before the sink can begin to finish
                raise

    def _stop(self, error: BaseException) -> None:
        """Wake all actors after Ctrl-C, or after an error of `on_tick`.

        When the user stops a run, what it has written may be of use; after an error nobody wants
        it.
        """
        self.stopped = True
        self._is_given_up = not isinstance(error, KeyboardInterrupt | StoppedError)
        self._cancel()

    def _wait(self, seconds: float | None) -> bool:
        """Wait until every actor has ended, or all items are in the sink; True in the first case.

        Thread.join cannot be used: after a Ctrl-C inside it, Python 3.11 takes a running thread for
        a finished one.
        """
        with self._ended:
            self._ended.wait_for(
                lambda: not self._running or (self._are_all_in and not self._are_all_told), seconds
            )
            return self._running == 0

    def _let_finish(self) -> None:
        """Let the sink finish: it waits until on_tick has been told of all items."""
        with self._ended:
            self._are_all_told = True
            self._ended.notify_all()

    def _start(self) -> list[threading.Thread]:
        jobs: list[tuple[str, Callable[[], None]]] = [(self.source[0], self._run_source)]
        for index, group in enumerate(self._groups):
            jobs.append((group[0][0], partial(self._run_group, index, group)))
        jobs.append((self.sink[0], self._run_sink))
        # daemons, so that a codec that hangs cannot keep the process from ending
        threads = [
            threading.Thread(target=self._guard, args=(job,), name=f"makeup-{name}", daemon=True)
            for name, job in jobs
        ]
        for thread in threads:
            with self._ended:
                self._running += 1
            try:
                thread.start()
            except BaseException:  # the system has no more threads: those that run are cancelled
                with self._ended:
                    self._running -= 1
                raise
        return threads

    def _guard(self, job: Callable[[], None]) -> None:
        try:
            job()
        except ChannelClosed:
            pass  # the run is over, for a reason that is recorded already
        except BaseException as error:  # noqa: BLE001  # raised again by `run`
            with self._ended:
                if self._first_error is None:
                    self._first_error = error
            self._cancel()
        finally:
            with self._ended:
                self._running -= 1
                self._ended.notify_all()

    def _cancel(self) -> None:
        for channel in self.channels:
            channel.cancel()

    def _stopwatch(self, name: str) -> Stopwatch:
        return Stopwatch(self.times[name], self._observe and partial(self._observe, name))

    def _run_source(self) -> None:
        name, items = self.source
        out, stopwatch = self.channels[0], self._stopwatch(name)
        with closing(items):
            while True:
                with stopwatch:
                    item = next(items, _END)
                if item is _END:
                    break
                stopwatch.times.items += 1
                out.send(item)
                del item
        out.close()

    def _run_group(self, index: int, group: list[tuple[str, Stage]]) -> None:
        inbox, out = self.channels[index], self.channels[index + 1]
        steps = [(self._stopwatch(name), stage) for name, stage in group]
        for items in inbox.batches(inbox.capacity):
            self._pass(items, steps, out)
        if inbox.is_cancelled:  # nobody waits for what the stages still hold
            return
        for index_of_stage, (_, stage) in enumerate(steps):
            for item in getattr(stage, "drain", tuple)():
                self._pass([item], steps[index_of_stage + 1 :], out)
        out.close()

    @staticmethod
    def _pass(items: list[Any], steps: list[tuple[Stopwatch, Stage]], out: Channel[Any]) -> None:
        """Empty a list of items: pass each through the stages and send it on, unless a stage holds
        it back.

        Each stage works on all items before the next one does, and so finds its own code and data
        in the cache, which other stages would evict.
        """
        for stopwatch, stage in steps:
            for _ in range(len(items)):
                with stopwatch:
                    item = stage(items.pop(0))
                stopwatch.times.items += 1
                if item is not None:
                    items.append(item)
                del item  # a frame must not stay in memory while the next one is waited for
        while items:
            out.send(items.pop(0))

    def _run_sink(self) -> None:
        name, sink = self.sink
        stopwatch = self._stopwatch(name)
        for item in self.channels[-1]:
            with stopwatch:
                sink(item)
            stopwatch.times.items += 1
            del item
        with self._ended:
            self._are_all_in = True
            self._ended.notify_all()
            self._ended.wait_for(lambda: self._are_all_told)
        with self._ticking:
            self._is_finishing, stopped = True, self.stopped
        if self._first_error is None and not self._is_given_up:
            with stopwatch:
                sink.finish(stopped)
            self._is_whole = not stopped
