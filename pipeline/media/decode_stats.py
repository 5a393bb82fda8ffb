"""Counts what came out of a file, and compares that with what the file promised."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import av
from makeup_video.pipeline.errors import DecodeError, UsageError, option
from makeup_video.pipeline.media.duration import beyond_end
from makeup_video.pipeline.media.frame_times import FrameTimes
from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.media.trim import Trim

_SHORT_SECONDS = Fraction(1, 2)  # headers are rounded; half a second less is a truncated file


@dataclass(slots=True)
class DecodeStats:
    """Counts of what came out of the input, and of what was wrong with it.

    corrupt_frames: decoded with visible damage.  lost_frames: in the file, but not decodable.
    mended_times: frames without a time, or with one that did not increase.
    moved: one line for each place from which all times move; this loses nothing.
    """

    frames: int = 0
    packets: int = 0
    corrupt_frames: int = 0
    lost_frames: int = 0
    decode_errors: int = 0
    mended_times: int = 0
    moved: list[str] = field(default_factory=list)
    truncated: bool = False

    @property
    def is_damaged(self) -> bool:
        return bool(self.decode_errors or self.corrupt_frames or self.lost_frames or self.truncated)


class Account:
    """Compares what a file promises with what a decoder finds in it.

    times: the times of the pictures decoded so far.
    stats: the decoder counts in these; complete after `close`.
    beyond_pts: time of the first picture after the trim's end; None until that picture has come.
    """

    def __init__(self, source: VideoSource, trim: Trim[av.VideoFrame], times: FrameTimes) -> None:
        self.stats = DecodeStats()
        self.beyond_pts: int | None = None
        self._source, self._trim, self._times = source, trim, times
        self._origin = source.start_seconds
        self._ends: dict[int, int] = {}  # by stream: where its packets read so far end, in ticks

    def note(self, packet: Any) -> None:
        """Note where a packet of any stream ends."""
        if packet.pts is not None and packet.size:
            index, end = packet.stream.index, packet.pts + (packet.duration or 0)
            self._ends[index] = max(self._ends.get(index, 0), end)

    def begin(self) -> None:
        """Note whether all times move, once the time of the first frame is known."""
        shift = self._trim.shift
        if not shift or self._trim.start is not None:  # an excerpt begins at 0 in any case
            return
        if shift < 0:
            why = "later, since the video began before 0"
        else:
            why = "earlier, since the file's clock begins that late"
        self.stats.moved.append(f"all times: {_in_words(abs(shift))} {why}")

    def close(self, jumps: Sequence[tuple[Fraction, Fraction]]) -> None:
        """Count the frames that the file promised and that did not come.

        jumps: see ClockJumps.
        Raises DecodeError when nothing came, and UsageError when the video ends before the trim's
        start or begins after its end.
        """
        stats, source = self.stats, self._source
        stats.mended_times = self._times.mended
        is_whole = self._trim.start is None and self._trim.end is None
        if is_whole:
            promised = self._promised_frames()
            stats.truncated |= promised > stats.packets or self._ends_early()
            if stats.is_damaged:
                stats.lost_frames = max(0, promised - stats.frames)
        if not stats.frames:
            self._check_excerpt()
            where = "in it" if is_whole else "in the chosen excerpt"
            raise DecodeError(
                f"{source.path}: no frame could be decoded {where} (packets: {stats.packets}, "
                f"errors: {stats.decode_errors}). Give a file that plays.",
                shows_nothing=True,
            )
        stats.moved += [
            f"all times from {_in_words(at - self._origin)} on: "
            f"{_in_words(abs(by))} {'later' if by > 0 else 'earlier'}, since the clock jumps there"
            for at, by in jumps
        ]

    @property
    def expected_frames(self) -> int | None:
        """How many frames will come, as far as the container declares it."""
        expected, trim, rate = self._source.expected_frames, self._trim, self._source.rate
        if expected is None or (trim.start is None and trim.end is None):
            return expected
        end = expected / rate
        if trim.end is not None:
            end = min(end, trim.end - self._origin)
        start = self._origin if trim.start is None else trim.start
        return max(0, round((end - (start - self._origin)) * rate))

    def _promised_frames(self) -> int:
        source = self._source
        if "mp4" not in source.container.format.name:
            return self.stats.packets
        # frames that an edit list hides are not lost
        return sum(not entry.is_discard for entry in source.video.index_entries)

    def _ends_early(self) -> bool:
        """True when a Matroska file is shorter than its header declares; it has no frame count."""
        container = self._source.container
        if "matroska" not in container.format.name or container.duration is None:
            return False
        return Fraction(container.duration, av.time_base) - self._file_end_seconds > _SHORT_SECONDS

    @property
    def _file_end_seconds(self) -> Fraction:
        """Where the packets read so far end, on the file's clock."""
        streams = self._source.container.streams
        ends = [end * streams[index].time_base for index, end in self._ends.items()]
        return max(ends, default=Fraction(0))

    def _check_excerpt(self) -> None:
        """Raises UsageError when all pictures lie before the trim's start, or after its end.

        The length of some files is known only once they have been read.
        """
        start, source, times = self._trim.start, self._source, self._times
        if times.last_pts is None or self.stats.decode_errors:
            return
        if self.beyond_pts is not None and self._trim.end is not None:
            first = self.beyond_pts * source.time_base - self._origin
            raise UsageError(
                f"{option('end_seconds')} {float(self._trim.end - self._origin):g} s is "
                f"before the first frame: {source.path} has frames from {float(first):.2f} s on; "
                "choose a later time"
            )
        if start is None:
            return
        end = (times.last_pts + times.last_duration) * source.time_base
        if max(end, self._file_end_seconds) <= start:
            last = max(end, self._file_end_seconds) - self._origin
            raise beyond_end(source, start - self._origin, last)
        raise UsageError(
            f"{option('start_seconds')} {float(start - self._origin):g} s is beyond the last "
            f"frame: {source.path} has frames until {round(float(end - self._origin), 2)} s"
        )


def _in_words(seconds: Fraction) -> str:
    """A time in seconds, such as "3.03 s"."""
    return f"{round(float(seconds), 2):.12g} s"
