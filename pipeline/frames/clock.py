"""Time as the frames tell it: seconds that never stand still, and arrival times made even."""

from makeup_video.pipeline.frames.frame import Frame

GAP_SECONDS = 0.15  # a face that was away for longer is a new one: four frames at 30 fps
_STEP_SHARE = 0.1  # of the newest step in the usual one
_LEAST_STEP = 0.8  # of the usual one; at less, what comes in pairs is left less even


class MediaClock:
    """Seconds since the first frame that never stand still or go back."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._last: float | None = None  # None, not falsehood: the first pts is often 0
        self._usual_step = 1 / 30

    def tick(self, frame: Frame) -> float:
        """The time of this frame. A repeated or earlier one counts as one usual step."""
        now = frame.seconds
        if self._last is not None:
            step = now - self._last
            if step > 0:
                self._usual_step = min(step, GAP_SECONDS)
            self.seconds += step if step > 0 else self._usual_step
        self._last = now
        return self.seconds


class EvenTimes:
    """Arrival times with the shortest steps made longer, to most of the usual one.

    A camera takes its pictures evenly, but a busy machine may be handed two at once. As times stand, the
    second would show enormous noise, and hardly count. What was added is taken off the steps after it.
    """

    def __init__(self) -> None:
        self._arrived: float | None = None
        self._told = 0.0
        self._usual_step = 0.0

    def __call__(self, seconds: float) -> float:
        """seconds: each more than the last."""
        if self._arrived is not None:
            step = seconds - self._arrived
            share = _STEP_SHARE if step < GAP_SECONDS else 1  # a pause tells of no usual step
            self._usual_step += share * ((step if step < GAP_SECONDS else 0) - self._usual_step)
            self._told = max(seconds, self._told + _LEAST_STEP * self._usual_step)
        else:
            self._told = seconds
        self._arrived = seconds
        return self._told
