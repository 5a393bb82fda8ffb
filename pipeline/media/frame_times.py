"""Presentation times that strictly increase, whatever the container declares."""

import math
from collections.abc import Callable, Iterable, Iterator

import av
from makeup_video.pipeline.media.input_file import VideoSource

_LONGEST_SECONDS = 2**52  # no video lasts that long; in milliseconds it still fits into 64 bits
_LITTLE_SECONDS = 1  # a time further behind than this means that the clock has begun anew


def has_guessed_times(source: VideoSource) -> bool:
    """True where FFmpeg makes up the times of the pictures, and gets their order wrong.

    AVI stores no presentation times.
    """
    return (
        source.container.format.name == "avi"
        and source.video.name in ("h264", "hevc")
        and bool(source.video.codec_context.has_b_frames)
    )


def until_next(
    pictures: Iterable[tuple[av.VideoFrame, int]], end: int | None, stays: Callable[[], bool]
) -> Iterator[tuple[av.VideoFrame, int, int]]:
    """(picture, time, duration) in order of time; no picture lasts beyond the next one's time.

    mp4 stores durations in the order of decoding, so FFmpeg may give the duration of a still
    picture to another one.
    end: where the last picture ends at the latest; None: where its own duration ends.  stays:
    called after the last picture; True: that picture lasts until `end` in any case.
    """
    held: tuple[av.VideoFrame, int] | None = None
    for picture, pts in pictures:
        if held is not None:
            yield *held, min(held[0].duration, pts - held[1])
        held = picture, pts
    if held is not None:
        picture, pts = held
        duration = picture.duration
        if end is not None and end > pts:
            duration = end - pts if stays() else min(duration, end - pts)
        yield picture, pts, duration


class FrameTimes:
    """Gives every decoded picture a time in ticks of the source, later than the one before.

    mended: how many pictures had no time, or one that did not increase.
    last_pts, last_duration: of the last picture, in ticks; None and 1 before the first.
    """

    def __init__(self, source: VideoSource) -> None:
        # in ticks, since fractions for every picture would take several times as long
        self._longest = math.floor(_LONGEST_SECONDS / source.time_base)
        self._little = math.floor(_LITTLE_SECONDS / source.time_base)
        self._own: int | None = None  # the last picture's time as the file gives it
        self.mended = 0
        self.last_pts: int | None = None
        self.last_duration = 1
        self._guesses_wrong = has_guessed_times(source)
        self._dts_delay: int | None = None

    def __call__(self, picture: av.VideoFrame) -> int:
        """The time of a picture; durations beyond all reason become 0."""
        pts = self._pts_from_dts(picture) if self._guesses_wrong else picture.pts
        if pts is not None and abs(pts) > self._longest:
            pts = None
        if picture.duration > self._longest:
            picture.duration = 0
        last, own = self.last_pts, pts
        if pts is None or (last is not None and pts <= last):
            self.mended += 1
            pts = 0 if last is None else last + self._step(last, own)
        if own is not None:
            self._own = own
        self.last_pts = pts
        self.last_duration = max(1, picture.duration or self.last_duration)
        return int(pts)

    def _step(self, last: int, pts: int | None) -> int:
        """The step from the last picture's time to a picture whose own time does not increase.

        Usually that is the last duration. But where the file's own times still increase, a little
        behind the mended times, it is at most half of the file's step. Otherwise the mended times
        would stay ahead where pictures last longer than the file's steps.
        """
        if pts is None or self._own is None or pts <= self._own or last - pts > self._little:
            return self.last_duration
        return max(1, min(self.last_duration, (pts - self._own) // 2))

    def _pts_from_dts(self, picture: av.VideoFrame) -> int | None:
        """AVI's decoding times, moved so that the first picture keeps its own time."""
        if picture.dts is None:
            return None if self.last_pts is None else self.last_pts + self.last_duration
        if self._dts_delay is None:
            self._dts_delay = picture.dts - (picture.pts or 0)
        return int(picture.dts - self._dts_delay)
