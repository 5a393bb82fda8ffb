"""Opens an input file and chooses the video stream to paint."""

import logging
import re
import threading
from collections.abc import Generator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
from av.stream import Disposition
from makeup_video.pipeline.errors import DecodeError, InputError, reason_of
from makeup_video.pipeline.files.marks import PNG_MARK
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.media.gif import is_opaque
from makeup_video.pipeline.media.mp4_boxes import lacks_index

# Containers and bare streams only. A playlist (hls, concat, dash, sdp) would make FFmpeg open files
# or addresses that the user never named, and a list of protocols alone does not prevent that.
_FORMATS = (
    "mov,mp4,m4a,3gp,3g2,mj2", "matroska,webm", "avi", "mpegts", "mpeg", "flv", "asf", "ogg",
    "mxf", "nut", "ivf", "gxf", "dv", "rm", "wtv", "h264", "hevc", "vvc", "obu", "av1", "m4v",
    "mpegvideo", "mjpeg", "vc1", "yuv4mpegpipe", "gif", "apng", "wav", "mp3", "aac", "flac",
)  # fmt: skip
# FFmpeg looks 5 s ahead to find out what each stream holds. Where a stream is announced and has not
# begun by then, as in broadcasts, the file is opened again with these limits.
_LOOK_FURTHER = {
    "analyzeduration": str(100 * 1_000_000),  # microseconds
    "probesize": str(50 * 1_000_000),  # bytes, which FFmpeg keeps in memory
}
_STREAM_LINE = re.compile(r"^ *Stream #0:(\d+)\S*: (\w+): ([^\s,]+)", re.MULTILINE)
logging.getLogger("libav").addHandler(logging.NullHandler())  # else Python prints PyAV's warnings
_log_level = threading.Lock()  # held while FFmpeg's level, a global, is another
_FREE_CLOCKS = "mpegts", "mpeg"  # containers whose clock may begin at any time
_FAKE_RATE = 240  # FFmpeg guesses rates such as 1000 or 90000 for files of variable frame rate


@dataclass(frozen=True, slots=True)
class VideoSource:
    """An open input. `container` and `video` are PyAV's; the rest is read when the file is opened.

    rate: frames per second for display and rate control, never for times.
    expected_frames: the container's count, for progress; None when it declares none.
    has_alpha: the video has transparency.  is_opaque: its pixel format has, but no picture uses it.
    tags: the container's colour tags, for frames that have none of their own.
    """

    path: Path
    container: Any
    video: Any
    rate: Fraction
    expected_frames: int | None
    has_alpha: bool
    is_opaque: bool
    tags: ColourTags
    # by stream index: a mark of the caller that got the stream's own decoder
    _taken: dict[int, object] = field(default_factory=dict, repr=False)
    _reopened: list[Any] = field(default_factory=list, repr=False)

    def decoder_of(self, stream: Any) -> Any:
        """Return a decoder for one of the file's streams, to be used for one output only.

        Several outputs of one run convert the same packets. A decoder keeps a state, so each output
        needs its own. The first call returns the stream's own decoder; each later call opens the
        file again. Any thread may call this. Raises InputError where the file cannot be opened
        again.
        """
        mine = object()
        if self._taken.setdefault(stream.index, mine) is mine:
            return stream.codec_context
        return self.open_again().streams[stream.index].codec_context

    def open_again(self) -> Any:
        """The file opened once more, until `close`. Raises InputError."""
        container = open_container(self.path)
        self._reopened.append(container)
        return container

    @property
    def time_base(self) -> Fraction:
        base: Fraction = self.video.time_base
        return base

    @property
    def start_seconds(self) -> Fraction:
        """Where a player begins: the first time of sound or picture, exact.

        In the recording of a broadcast that may be any time, even one before 0 where the clock
        wraps. In other files players do not show what lies before 0.
        """
        starts = [
            stream.start_time * stream.time_base
            for stream in self.container.streams
            if stream.type in ("audio", "video")
            and stream.start_time is not None
            and not is_cover(stream)
        ]
        start = min(starts, default=Fraction(0))
        return start if self.has_free_clock else max(Fraction(0), start)

    @property
    def late_start(self) -> Fraction:
        """Seconds to subtract from all times of an MPEG stream whose clock begins late.

        A whole number of the video's ticks; 0 for a clock that begins before 1 s.
        The clock of an MPEG stream may begin anywhere. Without this, a late start would become an
        empty edit in mp4, which players wait through. In other containers a late start is intended.
        """
        start = self.start_seconds
        is_late = start >= 1 and self.has_free_clock
        return start // self.time_base * self.time_base if is_late else Fraction(0)

    @property
    def has_free_clock(self) -> bool:
        """True for MPEG streams, whose clock may begin at any time and jump."""
        return self.container.format.name in _FREE_CLOCKS

    @property
    def bit_depth(self) -> int:
        fmt = self.video.codec_context.format
        return int(fmt.components[0].bits) if fmt else 8

    @property
    def frame_px(self) -> int:
        context = self.video.codec_context
        return int(context.width * context.height)

    def close(self) -> None:
        for container in (self.container, *self._reopened):
            container.close()


def open_container(path: Path) -> Any:
    """Open a media file and nothing else: no network, no playlist, no other file.

    Raises InputError with FFmpeg's reason.
    """
    try:
        container = _opened(path)
        if any(lacks_format(stream) for stream in container.streams):
            container.close()
            container = _opened(path, **_LOOK_FURTHER)
        return container
    except (av.FFmpegError, ValueError) as error:
        if _lacks_index(path):
            raise InputError(
                f"{path} has no index: this mp4 or mov is still being written, was never finished, "
                "or was cut short. Wait until it is whole, copy it again, or repair it"
            ) from error
        raise InputError(
            f"{path} is not a video or picture file that can be read ({reason_of(error)}): give "
            "one that opens in a player or viewer; playlists are not followed"
        ) from error


def _opened(path: Path, **more: str) -> Any:
    options = {"protocol_whitelist": "file", "format_whitelist": ",".join(_FORMATS)}
    # With `file:` a name such as "concat:a|b" or "http:x" stays a file name. Metadata that is not
    # UTF-8 must not stop a run.
    return av.open(
        f"file:{path.absolute()}",
        format="apng" if _begins_as_png(path) else None,
        container_options=options | more,
        metadata_errors="replace",
    )


def _lacks_index(path: Path) -> bool:
    try:
        return lacks_index(path)
    except OSError:  # it is gone
        return False


def _begins_as_png(path: Path) -> bool:
    """True for a PNG: FFmpeg by itself sees an animation only if its mark is in the first 2 kB."""
    try:
        with path.open("rb") as file:
            return file.read(len(PNG_MARK)) == PNG_MARK
    except OSError:
        return False


def lacks_format(stream: Any) -> bool:
    """True for audio whose rate and channels are unknown, since FFmpeg has found no packet."""
    if stream.type != "audio" or stream.codec_context is None:
        return False
    return not (stream.rate and stream.codec_context.layout.nb_channels)


def packets_of(container: Any, *streams: Any) -> Generator[Any, None, None]:
    """All packets of these streams; of all streams known at opening when none is given."""
    try:
        yield from container.demux(streams or list(container.streams))
    except IndexError:
        return  # after the last packet PyAV 18 fails on streams that appeared since opening


def late_streams(container: Any) -> list[str]:
    """The streams that have appeared since the file was opened, such as "audio #2 (mp3)".

    mpegts, FLV and MPEG may announce a stream anywhere. PyAV neither lists such a stream nor
    returns its packets; only FFmpeg's own description of the file shows it.
    """
    with _log_level:
        level = av.logging.get_level()
        av.logging.set_level(av.logging.INFO)
        try:
            text = container.dumps_format()
        finally:
            av.logging.set_level(level)
    known = len(container.streams)
    found = [(int(number), kind, codec) for number, kind, codec in _STREAM_LINE.findall(text)]
    return [f"{kind.lower()} #{index} ({codec})" for index, kind, codec in found if index >= known]


def open_video(path: Path) -> VideoSource:
    """Open a file and choose the video to paint: the best one that is not cover art.

    Raises InputError, or DecodeError when the file has no video.
    """
    container = open_container(path)
    try:
        return _describe(path, container)
    except BaseException:
        container.close()
        raise


def is_cover(stream: Any) -> bool:
    """True for a picture that belongs to the file as a whole, such as an album cover."""
    return bool(stream.disposition & (Disposition.attached_pic | Disposition.timed_thumbnails))


def _describe(path: Path, container: Any) -> VideoSource:
    best = container.streams.best("video")
    videos = [s for s in container.streams.video if not is_cover(s)]
    if not videos:
        found = [
            f"{s.type}/{getattr(s, 'name', None) or 'unknown'}" for s in container.streams
        ] or ["nothing"]
        raise DecodeError(
            f"{path} has no video stream (found: {', '.join(found)}). Give a file that has one."
        )
    known = [s for s in videos if s.codec_context is not None]
    video = best if best in known else (known or videos)[0]
    if video.codec_context is None:
        raise DecodeError(f"{path}: this build of FFmpeg has no decoder for its video stream")
    rate = _sane_rate(video)
    expected = video.frames or _frames_from_duration(container, video, rate)
    fmt = video.codec_context.format
    alpha = (fmt is not None and any(c.is_alpha for c in fmt.components)) or _alpha_mode(video)
    opaque = container.format.name == "gif" and _is_opaque_gif(path)
    tags = ColourTags.of(video.codec_context)
    return VideoSource(path, container, video, rate, expected, alpha and not opaque, opaque, tags)


def _is_opaque_gif(path: Path) -> bool:
    with open_container(path) as again:
        return is_opaque(path, again)


def _alpha_mode(video: Any) -> bool:
    """True when a tag declares VP8/VP9 transparency, which WebM keeps beside the picture."""
    tags = {key.lower(): value for key, value in video.metadata.items()}
    return tags.get("alpha_mode") == "1"


def _sane_rate(video: Any) -> Fraction:
    for rate in (video.average_rate, video.guessed_rate, video.base_rate):
        if rate and 0 < rate <= _FAKE_RATE:
            return Fraction(rate)
    return Fraction(30)


def _frames_from_duration(container: Any, video: Any, rate: Fraction) -> int | None:
    if video.duration:
        seconds = Fraction(video.duration * video.time_base)
    elif container.duration:
        seconds = Fraction(container.duration, av.time_base)
    else:
        return None
    return round(seconds * rate)
