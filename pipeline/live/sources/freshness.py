"""Tells whether a camera's picture is new: after a stall, drivers deliver old buffered pictures."""

_OLD_SECONDS = 0.1  # a picture that waited longer is dropped
_AT_ONCE_SECONDS = 0.001  # a read that takes less time found the picture waiting
_DRIFT = 2e-4  # a camera's clock may be slower than ours by this share
_JUMP_SECONDS = 60.0  # no picture waits this long, so the camera's clock was reset


class Freshness:
    """Measures by its timestamp how long a picture waited before it was read.

    V4L2 stamps a picture when the camera takes it. It does not matter which clock stamps: the least
    difference between stamp and time of reading belongs to a picture that was read at once.
    """

    def __init__(self) -> None:
        self._best: float | None = None
        self._last = 0.0
        self._doubted = False

    def __call__(
        self, stamped_seconds: float | None, read_seconds: float, took_seconds: float
    ) -> float | None:
        """When the picture arrived, on our clock; None for a picture too old to be shown.

        stamped_seconds: its stamp on the camera's clock; None when the camera sets no stamp.
        read_seconds: when the read ended, on our clock.  took_seconds: how long the read took.
        """
        if stamped_seconds is None:
            return read_seconds
        late = self._late(read_seconds - stamped_seconds, read_seconds)
        if took_seconds < _AT_ONCE_SECONDS:
            return None if late > _OLD_SECONDS else read_seconds - late
        if late <= _OLD_SECONDS:
            self._doubted = False
        elif self._doubted:
            # The read waited for this picture and for the one before, so neither was buffered. The
            # time from the camera to us has grown, as with long exposures in the dark.
            self._doubted, self._best = False, read_seconds - stamped_seconds
        else:
            # a slower camera, or the process was suspended during the read: the next picture tells
            self._doubted = True
            return None
        return read_seconds

    def _late(self, offset: float, now: float) -> float:
        if self._best is None or abs(offset - self._best) > _JUMP_SECONDS:
            self._best = offset
        self._best = min(self._best + _DRIFT * (now - self._last), offset)
        self._last = now
        return offset - self._best
