"""Clocks that run on frame times: media time that always advances, and evened arrival times."""

import math

from makeup_video.pipeline.frames.frame import Frame

# A face that was absent for longer is smoothed as a new one: four frames at 30 fps.
GAP_SECONDS = 0.15
_STEP_SHARE = 0.1  # weight of the newest step in the usual step
_LEAST_STEP = 0.8  # of the usual step; a smaller share leaves frames that come in pairs less even
_EARLY = 1e-6  # s, so that times at the edge of a slot fall into the same slot despite rounding


def slot(seconds: float, length_seconds: float) -> int:
    """The number of the slot that a time lies in, where time is cut into slots of equal length.

    What is done once in a slot is done at the same frames, wherever a run begins in the video.
    """
    return math.floor((seconds + _EARLY) / length_seconds)


def is_new_slot(seconds: float, last: float, length_seconds: float) -> bool:
    """True when `last`, -inf before the first time, lies in another slot than `seconds`.

    A clock that jumps back (a stream that starts again) comes to another slot, too.
    """
    return last == -math.inf or slot(seconds, length_seconds) != slot(last, length_seconds)


class MediaClock:
    """Seconds of the video, which begin with the first frame's own time.

    They always advance, whatever the frames' timestamps do.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._last: float | None = None  # compare with None: the first time is often 0
        self._usual_step = 1 / 30

    def tick(self, frame: Frame) -> float:
        """The time of this frame. A repeated or earlier timestamp counts as one usual step."""
        now = frame.seconds
        if self._last is None:
            self.seconds = now
        else:
            step = now - self._last
            if step > 0:
                self._usual_step = min(step, GAP_SECONDS)
            self.seconds += step if step > 0 else self._usual_step
        self._last = now
        return self.seconds


class EvenTimes:
    """Arrival times whose shortest steps are stretched to most of the usual step.

    A camera takes its pictures evenly, but a busy machine may receive two at once. With unchanged
    arrival times, the second picture would seem to hold enormous noise, and would hardly count. The
    steps that follow are shortened by the time that was added.
    """

    def __init__(self) -> None:
        self._arrived: float | None = None
        self._evened = 0.0
        self._usual_step = 0.0

    def __call__(self, seconds: float) -> float:
        """The evened time, `seconds` or later, and always later than the evened time before.

        seconds: later than in the call before.
        """
        if self._arrived is not None:
            step = seconds - self._arrived
            if step < GAP_SECONDS:  # a pause is no usual step
                self._usual_step += _STEP_SHARE * (step - self._usual_step)
            self._evened = max(seconds, self._evened + _LEAST_STEP * self._usual_step)
        else:
            self._evened = seconds
        self._arrived = seconds
        return self._evened
