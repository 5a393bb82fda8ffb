"""Keeps the pictures that one segment of a video needs: run-up, segment, and a few after it."""

from fractions import Fraction

import av
from makeup_video.pipeline.media.segments import Segment
from makeup_video.pipeline.media.trim import Trim


class SegmentTrim(Trim[av.VideoFrame]):
    """Takes pictures in order of time and returns those from the run-up on.

    after_frames: how many pictures after the segment are returned, for stages that look ahead.
    Times stay those of the whole video.
    """

    def __init__(self, segment: Segment, after_frames: int, tick: Fraction) -> None:
        start, end = (None if pts is None else pts * tick for pts in (segment.run_up, segment.end))
        super().__init__(start, end, tick)
        self.shift = self._shift = segment.shift * tick
        self._segment, self._left = segment, 0 if segment.is_last else after_frames

    def __call__(
        self, picture: av.VideoFrame, seconds: Fraction, duration: Fraction
    ) -> list[tuple[av.VideoFrame, Fraction, Fraction]]:
        if self.is_past_end or (self.start is not None and seconds < self.start):
            return []
        in_video = seconds - self._shift
        if self._segment.is_after(round(in_video / self.tick)):
            if not self._left:
                self.is_past_end = True
                return []
            self._left -= 1
        return [(picture, in_video, duration)]

    def finish(self) -> list[tuple[av.VideoFrame, Fraction, Fraction]]:
        return []

    def is_counted(self, seconds: Fraction) -> bool:
        return self._segment.holds(round((seconds - self._shift) / self.tick))
