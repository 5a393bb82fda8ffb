"""A file played in real time, as if it were a camera: how people rehearse, and what the tests use."""

import time
from collections.abc import Generator
from threading import Event
from typing import Any

import av
from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.errors import DecodeError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera
from makeup_video.pipeline.media.input_file import VideoSource, open_video, packets_of

_GAP_SECONDS = 10.0  # a longer way from one frame to the next is a fault in the file's clock
_LATE_FRAMES = 3  # more than these are left out, as a camera would
_FAR_BEHIND_SECONDS = 1.0  # from here on nothing is decoded before the next keyframe that is due


class Timeline:
    """Frame times of a file, again and again -> seconds since its beginning, strictly increasing.

    A time that is missing or goes back is mended by the frame's length, one that jumps is taken for a
    clock set anew, and another pass of the file goes on where the last one ended.
    """

    def __init__(self, frame_seconds: float) -> None:
        self._length = self._usual = frame_seconds
        self._last: float | None = None
        self._shift: float | None = None

    def begin_pass(self) -> None:
        self._shift = None

    def __call__(self, seconds: float | None, length: float = 0.0) -> float:
        """seconds: as the file says, None when it does not. length: how long the frame is shown, 0: not said."""
        at = self._last = self.peek(seconds)
        self._length = length if 0 < length <= _GAP_SECONDS else self._usual
        return at

    def peek(self, seconds: float | None) -> float:
        """What the next call with this time would return."""
        after = 0.0 if self._last is None else self._last + self._length
        if seconds is None:
            return after
        if self._shift is None or abs(seconds + self._shift - after) > _GAP_SECONDS:
            self._shift = after - seconds
        at = seconds + self._shift
        return at if self._last is None or at > self._last else after


class FileCamera:
    """Plays a file: every frame comes when it is due, and carries the time when it was due.

    dropped: frames left out because decoding was late.  damaged: packets that could not be decoded.
    Raises InputError or DecodeError when the file is none to play.
    """

    def __init__(self, source: VideoSource, *, loop: bool) -> None:
        self._source, self._loop = source, loop
        self.rate = source.rate
        self.name = source.path.name
        self.dropped = self.damaged = 0
        self.notice = ""
        self._door = NormaliseCamera(is_device=False, pixel_aspect=source.video.sample_aspect_ratio)
        self._closing = Event()
        self._timeline = Timeline(float(1 / source.rate))
        self._began = 0.0
        self._is_far_behind = False

    def close(self) -> None:
        self._closing.set()

    def frames(self) -> Generator[Frame, None, None]:
        """Raises DecodeError when nothing in the file can be decoded, or not be converted."""
        for picture, at in self._pictures():
            if not self._began:
                self._began = time.monotonic() - at
            due = self._began + at
            if self._leaves_out(due):
                continue
            frame = self._door(picture, due)
            if self._closing.wait(max(0.0, due - time.monotonic())):
                return
            if not self._leaves_out(due):  # we may have been stopped while we waited
                yield frame

    def _leaves_out(self, due: float) -> bool:
        """True, and counted, for a frame that would come too late."""
        late = time.monotonic() - due
        if late * self.rate <= _LATE_FRAMES:
            return False
        self.dropped += 1
        self._is_far_behind = late > _FAR_BEHIND_SECONDS
        return True

    def _pictures(self) -> Generator[tuple[av.VideoFrame, float], None, None]:
        """The pictures of the file, pass after pass, with the seconds since the beginning when each is due."""
        following: VideoSource | None = None
        while not self._closing.is_set():
            self._timeline.begin_pass()
            count = 0
            try:
                for picture in self._one_pass():
                    length = float(picture.duration * self._source.time_base)
                    yield picture, self._timeline(self._seconds(picture), length)
                    count += 1
                    if self._loop and following is None:
                        following = open_video(self._source.path)  # now, to be no pause at the seam
            finally:
                self._source.close()
                if following is not None and self._closing.is_set():
                    following.close()
            if not (count or self._is_far_behind or self._closing.is_set()):
                raise DecodeError(
                    f"{self._source.path}: no frame could be decoded. Give a file that plays."
                )
            if not self._loop:
                return
            # Another one, not sought back in: not every file can be, and its decoder starts afresh.
            self._source, following = following or open_video(self._source.path), None

    def _seconds(self, timed: Any) -> float | None:
        return None if timed.pts is None else float(timed.pts * self._source.time_base)

    def _one_pass(self) -> Generator[av.VideoFrame, None, None]:
        context = self._source.video.codec_context
        context.thread_type, context.thread_count = "AUTO", max(1, cores() // 2)
        packets = packets_of(self._source.container, self._source.video)
        while not self._closing.is_set():
            try:
                packet = next(packets, None)
            except av.FFmpegError:
                self.damaged += 1
                return  # a file that is cut short ends here
            if packet is None:
                return
            if self._is_far_behind and not self._catches_up(packet, context):
                continue
            try:
                yield from context.decode(packet)
            except av.FFmpegError:
                self.damaged += 1

    def _catches_up(self, packet: Any, context: Any) -> bool:
        """True for the packet with which decoding can go on: a keyframe that is not yet due."""
        if not packet.size:
            return False
        seconds = self._seconds(packet)
        if packet.is_keyframe and self._began + self._timeline.peek(seconds) >= time.monotonic():
            context.flush_buffers()
            self._is_far_behind = False
            return True
        self._timeline(seconds, float((packet.duration or 0) * packet.time_base))
        self.dropped += 1
        return False
