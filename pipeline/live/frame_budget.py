"""Chooses how much a slow machine leaves out of every live frame, without a clock of its own.

A second is *slow* when more than a tenth of its frames took over three quarters of the time between
two frames of the camera, or had frames dropped before them. Three slow seconds in a row lower the
quality by one level, so that a single hiccup costs nothing. A second is *easy* when at least
nineteen of twenty frames took at most two fifths of that time and none was dropped. Five easy
seconds in a row raise the quality by one level. If the machine is slow again within twenty seconds
of that, the next attempt needs twice as many easy seconds, up to 320.
"""

from makeup_video.pipeline.engine.quality import QualityLevel

NOTICES = {
    QualityLevel.FULL: "",
    QualityLevel.FEWER_DETECTIONS: "slow machine: looking for new faces less often",
    QualityLevel.SIMPLER_TRACKING: "slow machine: following faces more simply",
    QualityLevel.LESS_DETAIL: "slow machine: painting large faces with less detail",
}
LOWEST = max(QualityLevel)  # the lowest quality, at the level that leaves out most
TOO_SLOW = (
    "this machine is too slow for this camera, so frames are dropped: choose a smaller picture, or "
    "close other programs"
)
# A frame is late above this share of the time between two frames: capture and the pictures'
# encoders need the rest of both cores.
LATE_SHARE = 0.75
# A frame is easy up to this share of the same time. It is well below LATE_SHARE, since raising the
# quality at most about doubles the work.
EASY_SHARE = 0.4
LATE_FRAMES, UNEASY_FRAMES = 0.1, 0.05  # a larger share of such frames: slow, or not easy
SLOW_SECONDS = 3
EASY_SECONDS, MOST_EASY_SECONDS = 5, 320
PROBATION_SECONDS = 20  # slow again within this time: the quality was raised too early


class Budget:
    """Counts every frame's work; `level` is the quality level for the next frame."""

    def __init__(self) -> None:
        self.level = QualityLevel.FULL
        self._begin_second()
        self._slow = self._easy = self._fair = 0  # seconds in a row; fair: not slow
        self._seconds_at_level = 0
        self._is_retry = self._is_too_slow = False
        # For each level: how many easy seconds in a row raise the quality to this level.
        self._wanted = [EASY_SECONDS] * LOWEST

    def __call__(
        self, work_seconds: float, interval_seconds: float, dropped: int = 0
    ) -> QualityLevel:
        """Count a frame and return the level for the next one.

        work_seconds: time that all stages took.
        interval_seconds: from the arrival of the last painted frame to the arrival of this one.
        dropped: number of frames that arrived in between and were dropped.
        """
        dropped = max(0, dropped)  # the counts may belong to two cameras during an exchange
        if interval_seconds <= 0 or interval_seconds / (1 + dropped) > 1:
            return self.level  # the clock was set, or the camera was away
        self._seconds += interval_seconds
        self._frames.append((work_seconds, dropped))
        if self._seconds >= 1:
            self._end_second()
            self._begin_second()
        return self.level

    @property
    def notice(self) -> str:
        """One line for the user on what is left out, or on dropped frames; "" at full quality."""
        return TOO_SLOW if self._is_too_slow else NOTICES[self.level]

    def _begin_second(self) -> None:
        self._seconds = 0.0
        # of each frame: seconds of work, and how many frames were dropped before it
        self._frames: list[tuple[float, int]] = []

    def _end_second(self) -> None:
        count, dropped = len(self._frames), sum(dropped for _, dropped in self._frames)
        # the mean over the second, since a driver may deliver two frames at once
        camera_seconds = self._seconds / (count + dropped)
        late = sum(lost > 0 or work > LATE_SHARE * camera_seconds for work, lost in self._frames)
        uneasy = sum(work > EASY_SHARE * camera_seconds for work, _ in self._frames)
        is_slow = late > LATE_FRAMES * count
        is_easy = not dropped and uneasy <= UNEASY_FRAMES * count
        self._slow = self._slow + 1 if is_slow else 0
        self._easy = self._easy + 1 if is_easy else 0
        self._fair = 0 if is_slow else self._fair + 1
        self._seconds_at_level += 1
        if self._slow >= SLOW_SECONDS and self.level == LOWEST:
            self._is_too_slow = True
        elif self._slow >= SLOW_SECONDS:
            was_too_much = self._is_retry and self._seconds_at_level <= PROBATION_SECONDS
            wanted = 2 * self._wanted[self.level] if was_too_much else EASY_SECONDS
            self._wanted[self.level] = min(wanted, MOST_EASY_SECONDS)
            self._go_to(self.level + 1)
        elif self.level and self._easy >= self._wanted[self.level - 1]:
            self._go_to(self.level - 1)
            self._is_retry = True
        elif self._fair >= EASY_SECONDS:
            self._is_too_slow = False

    def _go_to(self, level: int) -> None:
        self.level = QualityLevel(level)
        self._is_retry = self._is_too_slow = False
        self._slow = self._easy = self._fair = self._seconds_at_level = 0
