"""How much a slow machine leaves out of every live frame, from level 0 (nothing) to 3.

The rule, which holds no clock: a second of frames is *slow* when more than a tenth of them took over
three quarters of the time that the camera has for one, or had others dropped beside them. Three slow
seconds in a row cost a level, so that one hiccup costs none. A second is *easy* when nineteen of twenty
frames took less than two fifths of that time and none was dropped. Five easy seconds in a row give a
level back; where that proved too much within twenty seconds, twice as many are wanted the next time.
"""

MOST = 3  # the highest level
TOLD = (
    "",
    "slow machine: looking for new faces less often",
    "slow machine: following faces more simply",
    "slow machine: painting large faces with less detail",
)
HOPELESS = (
    "this machine is too slow for this camera, so frames are left out: choose a smaller picture, or close"
    " other programs"
)
# Of the time between two frames: capture and the pictures' encoders want the rest of both cores.
LATE_SHARE = 0.75
# Of the same: what the level before takes more than this one is hardly as much again.
EASY_SHARE = 0.4
LATE_FRAMES, UNEASY_FRAMES = 0.1, 0.05  # more of them make a second slow, or not easy
SLOW_SECONDS = 3
EASY_SECONDS, MOST_EASY_SECONDS = 5, 320
PROBATION_SECONDS = 20  # who is slow again within this was given too much


class Budget:
    """Called once a frame; `level` is what is left out from the next one on.

    told: one line for people about it; empty at level 0.
    """

    def __init__(self) -> None:
        self.level = 0
        self._begin_second()
        self._slow = self._easy = self._fair = 0  # seconds in a row; fair: not slow
        self._seconds_at_level = 0
        self._is_retry = self._is_hopeless = False
        # By level: how many easy seconds give it back.
        self._wanted = [EASY_SECONDS] * MOST

    def __call__(self, work_seconds: float, interval_seconds: float, dropped: int = 0) -> int:
        """The level after a frame.

        work_seconds: of all stages.  interval_seconds: from the arrival of the last frame that was
        worked on to that of this one.  dropped: how many more the camera gave since the last call.
        """
        if interval_seconds <= 0 or interval_seconds / (1 + dropped) > 1:
            return self.level  # a clock that was set, or a camera that was away
        self._seconds += interval_seconds
        self._frames.append((work_seconds, dropped))
        if self._seconds >= 1:
            self._end_second()
            self._begin_second()
        return self.level

    @property
    def told(self) -> str:
        return HOPELESS if self._is_hopeless else TOLD[self.level]

    def _begin_second(self) -> None:
        self._seconds = 0.0
        self._frames: list[tuple[float, int]] = []  # work in seconds, and how many were dropped

    def _end_second(self) -> None:
        count, dropped = len(self._frames), sum(dropped for _, dropped in self._frames)
        # on the whole: a driver may hand over two at once
        camera_seconds = self._seconds / (count + dropped)
        late = sum(gone > 0 or work > LATE_SHARE * camera_seconds for work, gone in self._frames)
        uneasy = sum(work > EASY_SHARE * camera_seconds for work, _ in self._frames)
        is_slow = late > LATE_FRAMES * count
        is_easy = not dropped and uneasy <= UNEASY_FRAMES * count
        self._slow = self._slow + 1 if is_slow else 0
        self._easy = self._easy + 1 if is_easy else 0
        self._fair = 0 if is_slow else self._fair + 1
        self._seconds_at_level += 1
        if self._slow >= SLOW_SECONDS and self.level == MOST:
            self._is_hopeless = True
        elif self._slow >= SLOW_SECONDS:
            was_too_much = self._is_retry and self._seconds_at_level <= PROBATION_SECONDS
            wanted = 2 * self._wanted[self.level] if was_too_much else EASY_SECONDS
            self._wanted[self.level] = min(wanted, MOST_EASY_SECONDS)
            self._go_to(self.level + 1)
        elif self.level and self._easy >= self._wanted[self.level - 1]:
            self._go_to(self.level - 1)
            self._is_retry = True
        elif self._fair >= EASY_SECONDS:
            self._is_hopeless = False

    def _go_to(self, level: int) -> None:
        self.level, self._is_retry, self._is_hopeless = level, False, False
        self._slow = self._easy = self._fair = self._seconds_at_level = 0
