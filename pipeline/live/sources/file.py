"""A file played in real time as if it were a camera, for rehearsals and tests."""

import time
from collections.abc import Generator
from itertools import chain
from threading import Event
from typing import Any

import av
from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.errors import DecodeError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.sources.file_sound import FileSound, has_sound
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera
from makeup_video.pipeline.media.input_file import VideoSource, open_video, packets_of

_GAP_SECONDS = 10.0  # a longer gap between two frames is an error in the file's times
_LEAST_SECONDS = 1e-4  # the shortest time from a frame to the next
_LATE_FRAMES = 3  # a frame that is late by more frames than this is dropped, as a camera would do
_FAR_BEHIND_SECONDS = 1.0  # beyond this delay, decoding skips to a key frame that is not yet due
_LONGEST_GOP = 300  # packets from one key frame to the next; in a longer GOP, nothing is skipped


class Timeline:
    """Converts the frame times of repeated passes of a file to strictly increasing seconds from 0.

    A frame whose time is missing or goes back is due when the frame before it ends. A jump counts
    as a reset of the clock, and each pass goes on where the last one ended. After a frame that got
    a later time than its own, the following steps count half until the file's times catch up.
    """

    def __init__(self, frame_seconds: float) -> None:
        self._length = self._usual = frame_seconds
        self._last: float | None = None
        self._own: float | None = None  # the last frame's time in the file
        self._shift: float | None = None

    def begin_pass(self) -> None:
        """Treat the next time as the first of another pass."""
        self._shift = self._own = None

    def __call__(self, seconds: float | None, length: float = 0.0) -> float:
        """Convert a frame's time.

        seconds: its time in the file; None when missing.  length: its duration; 0 when missing.
        """
        due = self._last = self.due(seconds)
        self._own = self._own if seconds is None else seconds
        self._length = length if 0 < length <= _GAP_SECONDS else self._usual
        return due

    def due(self, seconds: float | None) -> float:
        """When a frame with this time in the file is due, without moving on to that frame.

        Only the shift changes: at the first time of a pass, and after a reset of the file's clock.
        """
        after = 0.0 if self._last is None else self._last + self._length
        if seconds is None:
            return after
        if self._shift is None or abs(seconds + self._shift - after) > _GAP_SECONDS:
            self._shift = after - seconds
        due = seconds + self._shift
        if self._last is None or due > self._last:
            return due
        if self._own is None or seconds <= self._own:
            return after
        return min(after, self._last + max((seconds - self._own) / 2, _LEAST_SECONDS))


class FileCamera:
    """Plays a file: every frame comes when it is due, and has that time.

    dropped: number of frames left out because decoding was late.
    damaged: number of packets that could not be decoded.
    rate: frames per second, as far as the file declares a rate.
    size: None, since there is no other size to choose.
    turn, zero_seconds: how far the file has played, for its sound; see file_sound.Playing.
    """

    size: str | None = None

    def __init__(self, source: VideoSource, *, loop: bool) -> None:
        self._source, self._loop = source, loop
        self.rate = source.rate
        self.path, self.name = source.path, source.path.name
        self.dropped = self.damaged = self.turn = 0
        self.zero_seconds: float | None = None
        self.notice = ""
        aspect = source.video.sample_aspect_ratio
        self._normalise = NormaliseCamera(is_device=False, pixel_aspect=aspect)
        self._closing = Event()
        self._timeline = Timeline(float(1 / source.rate))
        self._began: float | None = None  # the monotonic time when the first frame was due
        self._turn = 0  # of the last decoded picture; `turn` is that of the last due one
        self._is_far_behind = False
        self._plays_on_late = False  # nothing could be skipped: the next frame is due at once

    def close(self) -> None:
        self._closing.set()

    def file_sound(self) -> FileSound | None:
        """The sound of the file, in step with its pictures; None for a file without sound."""
        return FileSound(self.path, self) if has_sound(self.path) else None

    def frames(self) -> Generator[Frame, None, None]:
        """Yield each frame when it is due.

        Raises DecodeError when no frame can be decoded, or a frame cannot be converted. Raises
        InputError when the file cannot be opened for another pass.
        """
        for picture, seconds in self._pictures():
            if self._began is None or self._plays_on_late:
                self._began = time.monotonic() - seconds
                self._plays_on_late = False
            due, in_file, number = self._began + seconds, self._seconds(picture), self._turn
            frame = None if self._leaves_out(due) else self._normalise(picture, due)
            if frame is not None and self._closing.wait(max(0.0, due - time.monotonic())):
                return
            # not sooner: the sound under the last picture of a pass still plays
            if number != self.turn:
                self.zero_seconds = None  # first: the last pass's sound must not take the new zero
                self.turn = number
            if in_file is not None:
                self.zero_seconds = due - in_file
            # the process may have been suspended while it waited
            if frame is not None and not self._leaves_out(due):
                yield frame

    def _leaves_out(self, due: float) -> bool:
        """True for a frame that would come too late; counts it as dropped."""
        late = time.monotonic() - due
        if late * self.rate <= _LATE_FRAMES:
            return False
        self.dropped += 1
        self._is_far_behind = late > _FAR_BEHIND_SECONDS
        return True

    def _pictures(self) -> Generator[tuple[av.VideoFrame, float], None, None]:
        """Yield the pictures of all passes, each with the seconds from the start when it is due."""
        following: VideoSource | None = None
        while not self._closing.is_set():
            self._timeline.begin_pass()
            self._turn += 1
            count = 0
            try:
                for picture in self._one_pass():
                    length = float(picture.duration * self._source.time_base)
                    yield picture, self._timeline(self._seconds(picture), length)
                    count += 1
                    if self._loop and following is None:
                        # opened early, so there is no pause between passes
                        following = open_video(self._source.path)
            finally:
                self._source.close()
                if following is not None and self._closing.is_set():
                    following.close()
            if not (count or self._closing.is_set()):
                raise DecodeError(
                    f"{self._source.path}: no frame could be decoded. Give a file that plays."
                )
            if not self._loop:
                return
            # the file is opened again: not every file can seek, and the decoder must start fresh
            self._source, following = following or open_video(self._source.path), None

    def _seconds(self, timed: Any) -> float | None:
        return None if timed.pts is None else float(timed.pts * self._source.time_base)

    def _one_pass(self) -> Generator[av.VideoFrame, None, None]:
        context = self._source.video.codec_context
        context.thread_type, context.thread_count = "AUTO", max(1, cores() // 2)
        packets = self._packets()
        for packet in packets:
            for one in (
                self._caught_up(packet, packets, context) if self._is_far_behind else [packet]
            ):
                try:
                    yield from context.decode(one)
                except av.FFmpegError:
                    self.damaged += 1

    def _packets(self) -> Generator[Any, None, None]:
        """The packets of a pass, until `close`. A file that is cut short ends at the cut."""
        packets = packets_of(self._source.container, self._source.video)
        while not self._closing.is_set():
            try:
                packet = next(packets, None)
            except av.FFmpegError:
                self.damaged += 1
                return
            if packet is None:
                return
            yield packet

    def _caught_up(self, first: Any, rest: Generator[Any, None, None], context: Any) -> list[Any]:
        """The packets with which decoding goes on.

        That is the next key frame that is not yet due, and what comes before it is left out.
        Without one in the rest of the pass, or in a long GOP, the file plays on late, from the last
        key frame or from where it was: otherwise nothing would be shown from here on.
        """
        self._is_far_behind = False
        assert self._began is not None  # a frame was late, so a first frame was due
        held: list[Any] = []
        for packet in chain([first], rest):
            if packet.is_keyframe and packet.size:
                self._leave_out(held)
                held.clear()
                context.flush_buffers()
                if self._began + self._timeline.due(self._seconds(packet)) >= time.monotonic():
                    return [packet]
            held.append(packet)
            if len(held) > _LONGEST_GOP:
                break
        self._plays_on_late = True
        self._turn += 1  # the sound has played on, and must go back
        return held

    def _leave_out(self, packets: list[Any]) -> None:
        for packet in packets:
            length = float((packet.duration or 0) * packet.time_base)
            self._timeline(self._seconds(packet), length)
        self.dropped += len(packets)
