"""Bounded queues between two threads."""

from collections import deque
from collections.abc import Iterator
from threading import Condition
from typing import Generic, TypeVar

T = TypeVar("T")


class ChannelClosed(Exception):
    """The channel is closed or cancelled: nobody will receive what is sent."""


class Channel(Generic[T]):
    """A queue of at most `capacity` items; a sender waits while it is full.

    The sender calls `close` after its last item: the receiver gets what is left and stops. Anyone
    may call `cancel` when the run is over: items that wait are dropped, and both ends wake.
    """

    def __init__(self, name: str, capacity: int) -> None:
        if capacity < 1:
            raise ValueError(f"channel {name} needs a capacity of at least 1, got {capacity}")
        self.name = name
        self.capacity = capacity
        self._items: deque[T] = deque()
        self._changed = Condition()
        self._closed = False
        self._cancelled = False
        self._sent = 0
        self._fill_sum = 0

    @property
    def fill(self) -> int:
        """The number of items that wait now."""
        return len(self._items)

    @property
    def _has_ended(self) -> bool:
        return self._closed or self._cancelled

    @property
    def is_cancelled(self) -> bool:
        """True once `cancel` was called."""
        return self._cancelled

    @property
    def mean_fill(self) -> float:
        """The mean number of items that waited when another one was ready to be sent.

        Near the capacity the receiver is the bottleneck, near 0 the sender.
        """
        return self._fill_sum / self._sent if self._sent else 0.0

    def send(self, item: T) -> None:
        """Wait for room, then put the item in. Raises ChannelClosed once closed or cancelled."""
        with self._changed:
            waiting = len(self._items)
            while len(self._items) >= self.capacity and not self._has_ended:
                self._changed.wait()
            if self._has_ended:
                raise ChannelClosed(self.name)
            self._fill_sum += waiting
            self._sent += 1
            self._items.append(item)
            self._changed.notify_all()

    def __iter__(self) -> Iterator[T]:
        """Receive until the channel is closed and empty, or cancelled."""
        for items in self.batches(1):
            yield items.pop()

    def batches(self, most: int) -> Iterator[list[T]]:
        """Like iteration, but receives all items that wait, 1 to `most` of them, as one list.

        The receiver must empty each list: otherwise its items would stay in memory while the
        receiver waits for the next ones.
        """
        while True:
            with self._changed:
                while not self._items and not self._has_ended:
                    self._changed.wait()
                if not self._items or self._cancelled:
                    return
                items = [self._items.popleft() for _ in range(min(most, len(self._items)))]
                self._changed.notify_all()
            yield items

    def close(self) -> None:
        """End the channel after the last item."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def cancel(self) -> None:
        """End the channel at once."""
        with self._changed:
            self._cancelled = True
            self._items.clear()
            self._changed.notify_all()


class NewestChannel(Channel[T]):
    """A channel for items that must not get old: when it is full, the oldest item is dropped.

    A sender never waits.  dropped: how many items were dropped.
    """

    def __init__(self, name: str, capacity: int = 1) -> None:
        super().__init__(name, capacity)
        self.dropped = 0

    def send(self, item: T) -> None:
        """Put the item in without waiting. Raises ChannelClosed once closed or cancelled."""
        with self._changed:
            if len(self._items) >= self.capacity and not self._has_ended:
                self._items.popleft()
                self.dropped += 1
            super().send(item)
