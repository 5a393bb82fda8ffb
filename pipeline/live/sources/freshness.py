"""Whether a camera's picture is new: drivers keep some in buffers, which come out old after a stall."""

_OLD_SECONDS = 0.1  # a picture that waited longer than this is not shown any more
_AT_ONCE_SECONDS = 0.001  # a read that takes less found the picture waiting
_DRIFT = 2e-4  # by so much may a camera's clock go slower than ours
_JUMP_SECONDS = 60.0  # no picture waits so long: the camera's clock was set anew


class Freshness:
    """Tells how long a picture waited before it was read, by the stamp that it carries.

    V4L2 stamps a picture when the camera made it. On whose clock does not matter: the least distance
    from a stamp to the time of reading is that of a picture which was read at once.
    """

    def __init__(self) -> None:
        self._best: float | None = None
        self._last = 0.0
        self._doubted = False

    def __call__(
        self, stamped_seconds: float | None, read_seconds: float, took_seconds: float
    ) -> float | None:
        """When the picture arrived; None when it is too old to be shown.

        stamped_seconds: on the camera's clock, None: it has none.  read_seconds: when reading it ended, by
        ours.  took_seconds: how long the read waited.
        """
        if stamped_seconds is None:
            return read_seconds
        late = self._late(read_seconds - stamped_seconds, read_seconds)
        if took_seconds < _AT_ONCE_SECONDS:
            return None if late > _OLD_SECONDS else read_seconds - late
        if late <= _OLD_SECONDS:
            self._doubted = False
        elif self._doubted:
            # It was waited for, and so was the one before: it is the way from camera to us that has
            # become longer, as with long exposures in the dark.
            self._doubted, self._best = False, read_seconds - stamped_seconds
        else:
            self._doubted = True  # or we were stopped while we waited
            return None
        return read_seconds

    def _late(self, offset: float, now: float) -> float:
        if self._best is None or abs(offset - self._best) > _JUMP_SECONDS:
            self._best = offset
        self._best = min(self._best + _DRIFT * (now - self._last), offset)
        self._last = now
        return offset - self._best
