"""A sink made of several sinks, each of which may fail alone."""

import threading
from collections.abc import Callable, Sequence
from typing import Any

from makeup_video.pipeline.engine.channel import Channel
from makeup_video.pipeline.engine.runner import Sink

_CAPACITY = 1  # items that wait for a thread: frames are large


class FanOut:
    """Hands a copy of every item to each of several sinks.

    An error of one sink ends that sink alone, and is kept in `errors`. Once every sink has failed,
    the first error is raised, so that the run makes no more items.

    share(item): one copy of the item for each sink, in their order.
    sinks: in groups; the sinks of a group run in one thread, in turn. A group for each core is
    enough, because encoders have threads of their own.
    errors: for each sink the error that ended it, or None; an entry from elsewhere ends it, too.
    on_error(index): called once, in some thread, when an error has ended that sink.
    """

    def __init__(
        self,
        groups: Sequence[Sequence[Sink]],
        share: Callable[[Any], Sequence[Any]],
        on_error: Callable[[int], None] | None = None,
    ) -> None:
        self._share, self._on_error = share, on_error
        self.sinks = [sink for group in groups for sink in group]
        self.errors: list[Exception | None] = [None] * len(self.sinks)
        self._stopped = False
        self._channels: list[Channel[list[Any]]] = []
        self._threads: list[threading.Thread] = []
        self._spans: list[range] = []
        first = 0
        for group in groups:
            span = range(first, first + len(group))
            first = span.stop
            channel: Channel[list[Any]] = Channel(f"-> {span.start}..", _CAPACITY)
            self._spans.append(span)
            self._channels.append(channel)
            # a daemon, so that a codec that hangs cannot keep the process from ending
            thread = threading.Thread(
                target=self._run, args=(channel, span), name="makeup-fan-out", daemon=True
            )
            self._threads.append(thread)

    def __call__(self, item: Any) -> None:
        if all(self.errors):
            raise next(filter(None, self.errors))
        self._start()
        copies = self._share(item)
        groups = [list(copies[span.start : span.stop]) for span in self._spans]
        del copies  # no copy must stay in memory once its sink has taken it
        for channel in self._channels:
            channel.send(groups.pop(0))

    def finish(self, stopped: bool) -> None:
        """Let every sink that has not failed finish; returns when all have."""
        self._start()
        self._stopped = stopped
        for channel in self._channels:
            channel.close()
        self._join()

    def cancel(self) -> None:
        """End the threads. Sinks of a group that is not finishing yet never finish.

        Harmless after `finish`.
        """
        for channel in self._channels:
            channel.cancel()
        self._join()

    def _start(self) -> None:
        if not self._threads[0].ident:
            for thread in self._threads:
                thread.start()

    def _join(self) -> None:
        for thread in self._threads:
            if thread.ident:
                thread.join()

    def _run(self, channel: Channel[list[Any]], span: range) -> None:
        for copies in channel:
            for index in span:
                self._try(index, self.sinks[index], copies.pop(0))
            del copies
        if not channel.is_cancelled:
            for index in span:
                self._try(index, self.sinks[index].finish, self._stopped)

    def _try(self, index: int, work: Callable[[Any], None], argument: Any) -> None:
        if self.errors[index] is not None:
            return
        try:
            work(argument)
        except Exception as error:  # noqa: BLE001  # whoever made the sinks raises it
            self.errors[index] = self.errors[index] or error
            if self._on_error is not None:
                self._on_error(index)
