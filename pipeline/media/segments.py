"""Plans how a video is split: segments that begin at key frames, so that each can be painted alone.

Decoding begins some time before a segment's first frame. During this run-up, everything that
depends on earlier frames settles.
"""

from bisect import bisect_left
from dataclasses import dataclass, replace
from fractions import Fraction

import av
from makeup_video.pipeline.media.clock_jumps import ClockJumps
from makeup_video.pipeline.media.frame_times import has_guessed_times
from makeup_video.pipeline.media.input_file import VideoSource, packets_of
from makeup_video.pipeline.media.trim import STILL_SECONDS

RUN_UP_SECONDS = 2
_RUN_UP_FRAMES = 8  # at least, for videos of few frames a second
# As a share of the wanted length. A shorter rest is painted with the segment before it.
_LEAST_REST = Fraction(1, 2)
# Between the frames on both sides of a seam. Matroska rounds times to milliseconds, and the two
# times must still differ after that.
_LEAST_STEP_SECONDS = Fraction(2, 1000)


@dataclass(frozen=True, slots=True)
class Segment:
    """A span of a video. Times are in ticks of the source.

    first: time of the first frame.  end: of the first frame after it, None at the end of the video.
    run_up: time from which frames are decoded; None: from the beginning of the video.
    shift: subtracted from every time, so that the video begins at 0, or not before it.
    is_last: no segment follows, so the stages get no frame after `end`.
    """

    first: int
    end: int | None
    run_up: int | None
    shift: int
    is_last: bool = False

    def holds(self, pts: int) -> bool:
        """True for the time of a frame in this segment, and neither before nor after it.

        pts: the frame's time in the output, from which `shift` has been subtracted.
        """
        return not self.is_before(pts) and not self.is_after(pts)

    def is_before(self, pts: int) -> bool:
        """True for the time, in the output, of a frame of the run-up."""
        return pts + self.shift < self.first

    def is_after(self, pts: int) -> bool:
        """True for the time, in the output, of a frame after this segment."""
        return self.end is not None and pts + self.shift >= self.end

    def is_unseen(self, pts: int) -> bool:
        """True for the time, in the output, of a frame before the run-up."""
        return self.run_up is not None and pts + self.shift < self.run_up


@dataclass(frozen=True, slots=True)
class Plan:
    """segments: at least one, in order.  obstacle: why there is only one; "" if one is enough."""

    segments: tuple[Segment, ...]
    obstacle: str = ""


# Start and end of the part of a video to keep, in seconds from where the video begins.
Excerpt = tuple[Fraction | None, Fraction | None]


def plan_segments(
    source: VideoSource, seconds: Fraction, excerpt: Excerpt = (None, None), *, run_up: bool = True
) -> Plan:
    """Read the packets of a video, without decoding them, and choose where to split it.

    seconds: the length of a segment; the next key frame ends it.  run_up: False when no stage
    keeps anything from frame to frame.
    """
    found = _times_and_keys(source)
    if isinstance(found, str):
        return _whole(found)
    times, keys = found
    if not times:
        return _whole("")
    kept = _Kept(source, times, excerpt)
    if kept.begins_with_a_still:
        return _whole("its first frame was already on screen before the start")
    if kept.ends_with_a_still:
        return _whole("its last frame stays on screen beyond the end")
    if not (times := kept.times):
        return _whole("")
    keys = [key for key in keys if _is_apart(times, key, source.time_base)]
    starts = _starts(times, keys, seconds / source.time_base)
    is_long = (times[-1] - times[0]) * source.time_base > 2 * seconds
    if len(starts) == 1:
        return _whole("it has no key frame to split it at" if is_long else "")
    run_ups: list[int | None] = [kept.begins_at]
    run_ups += [_run_up(times, start, source) if run_up else start for start in starts[1:]]
    spans = zip(starts, [*starts[1:], kept.ends_at], run_ups, strict=True)
    segments = [Segment(first, end, before, kept.shift) for first, end, before in spans]
    segments[-1] = replace(segments[-1], is_last=True)
    return Plan(tuple(segments))


def _times_and_keys(source: VideoSource) -> tuple[list[int], list[int]] | str:
    """The times of all frames and those of key frames, each in order, or why they are unusable."""
    times, keys = [], []
    clock = ClockJumps(source)
    try:
        for packet in packets_of(source.container, source.video):
            if not packet.size or packet.is_discard:
                continue  # empty, or hidden by an edit list
            clock(packet)
            if clock.jumps:
                return "its clock jumps"
            times.append(packet.pts)
            if packet.is_keyframe:
                keys.append(packet.pts)
    except av.FFmpegError:
        return "the file is damaged"
    if None in times or has_guessed_times(source) or len(set(times)) < len(times):
        return "its frames have no times of their own"
    return sorted(times), sorted(keys)


class _Kept:
    """The frames that an excerpt of a video keeps, as Trim keeps them.

    times: of the frames, in order.
    begins_at: time of the first frame; None when the excerpt begins where the video does.
    ends_at: time of the first frame after the excerpt; None when it ends where the video does.
    """

    def __init__(self, source: VideoSource, times: list[int], excerpt: Excerpt) -> None:
        tick, origin = source.time_base, source.start_seconds
        start, end = (None if one is None else one + origin for one in excerpt)
        # a start of 0 keeps what lies before the first sound, as in a run without segments
        first = 0 if not excerpt[0] or start is None else bisect_left(times, start / tick)
        last = len(times) if end is None else bisect_left(times, end / tick)
        self.times = times[first:last]
        is_cut = bool(excerpt[0])
        self.begins_at = self.times[0] if is_cut and self.times else None
        self.ends_at = times[last] if last < len(times) else None
        self.shift = 0
        self.begins_with_a_still = self.ends_with_a_still = False
        if self.times:
            self.ends_with_a_still = (
                self.ends_at is not None and (self.ends_at - self.times[-1]) * tick > STILL_SECONDS
            )
            late_start = int(source.late_start / tick)
            self.shift = self.times[0] if is_cut else min(late_start, self.times[0])
            self.begins_with_a_still = (
                is_cut and start is not None and self.times[0] * tick - start > STILL_SECONDS
            )


def _whole(obstacle: str) -> Plan:
    return Plan((Segment(0, None, None, 0),), obstacle)


def _is_apart(times: list[int], key: int, tick: Fraction) -> bool:
    """True when the frame before a key frame is far enough from it for a seam."""
    index = bisect_left(times, key)
    return index > 0 and (key - times[index - 1]) * tick >= _LEAST_STEP_SECONDS


def _starts(times: list[int], keys: list[int], ticks: Fraction) -> list[int]:
    """Return when each segment begins: the video's start, then key frames `ticks` or more apart."""
    starts = [times[0]]
    for key in keys:
        if key - starts[-1] >= ticks and times[-1] - key >= ticks * _LEAST_REST:
            starts.append(key)
    return starts


def _run_up(times: list[int], first: int, source: VideoSource) -> int:
    """The time from which frames are decoded, so that everything has settled at `first`."""
    index = bisect_left(times, first - RUN_UP_SECONDS / source.time_base)
    return times[max(0, min(index, bisect_left(times, first) - _RUN_UP_FRAMES))]
