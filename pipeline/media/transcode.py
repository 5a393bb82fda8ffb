"""Changes the codec of audio and subtitle streams that the output's container cannot hold."""

from fractions import Fraction
from typing import Any

import av
from av.subtitles.subtitle import SubtitleSet
from makeup_video.pipeline.media.titles import OneAtATime, Title, joined

_AUDIO = {"webm": "libopus", "mp4": "aac", "mov": "aac", "matroska": "flac"}
_SUBTITLES = {"webm": "webvtt", "mp4": "mov_text", "mov": "mov_text", "matroska": "subrip"}
_BITMAP = {
    "dvd_subtitle",
    "dvdsub",
    "hdmv_pgs_subtitle",
    "pgssub",
    "dvb_subtitle",
    "dvbsub",
    "xsub",
}
_OPUS_RATE = 48000
# The channel layouts that Opus and AAC both know; other numbers of channels are mixed to _MIXED_TO.
_MIXED_TO = "stereo"
_LAYOUTS = {1: "mono", 2: "stereo", 3: "3.0", 4: "quad", 5: "5.0", 6: "5.1", 7: "6.1", 8: "7.1"}
# libopus exchanges channels of these two, so sound of 5 or 7 channels gets a silent one more.
_OPUS_LAYOUTS = {5: "5.1", 7: "7.1"}


def audio_codec_for(container_format: str) -> str:
    """The codec to which audio is converted for one of our containers."""
    return _AUDIO[container_format]


def subtitle_codec_for(container_format: str, stream: Any) -> str | None:
    """The text codec of the container; None for bitmap subtitles, which hold no text."""
    return None if stream.name in _BITMAP else _SUBTITLES.get(container_format)


def can_be_mixed(source: Any) -> bool:
    """False for sound whose channels have no known places, such as nine of them."""
    context = source.codec_context
    frame = av.AudioFrame("s16", context.layout.name, 1024)
    frame.sample_rate, frame.pts, frame.time_base = _OPUS_RATE, 0, Fraction(1, _OPUS_RATE)
    try:
        layout = _LAYOUTS.get(context.layout.nb_channels, _MIXED_TO)
        return bool(av.AudioResampler("fltp", layout, _OPUS_RATE).resample(frame))
    except av.FFmpegError:
        return False


def _layout_for(codec: str, channels: int) -> str:
    usual = _LAYOUTS.get(channels, _MIXED_TO)
    return _OPUS_LAYOUTS.get(channels, usual) if codec == "libopus" else usual


class AudioConverter:
    """Converts the packets of one audio stream to another codec, at the same times.

    The source's rate and channels may change within the stream. The output keeps those at the
    beginning, in the layout of `_layout_for`.  source: passes `can_be_mixed`.
    decoder: of the source's stream, used by nobody else.
    """

    def __init__(self, container: Any, source: Any, codec: str, decoder: Any) -> None:
        self._decoder = decoder
        self._rate = _OPUS_RATE if codec == "libopus" else _rate_for(codec, source.rate)
        self._layout = _layout_for(codec, source.codec_context.layout.nb_channels)
        self.stream = container.add_stream(codec, rate=self._rate)
        context = self.stream.codec_context
        context.layout = self._layout
        context.time_base = Fraction(1, self._rate)
        if codec != "flac":
            # 128 kbit/s for stereo, more for more channels: transparent for speech and music
            context.bit_rate = 64000 * max(2, context.layout.nb_channels)
        self._input: tuple[str, str, int] | None = None  # format, layout and rate of the last frame
        self._resampler = self._new_resampler()

    def __call__(self, packet: Any) -> list[Any]:
        """Raises FFmpeg's error when the packet is damaged."""
        return self._encode(self._decoder.decode(packet))

    def flush(self) -> list[Any]:
        """The packets that decoder, resampler and encoder still hold."""
        if not self._decoder.is_open:
            return []
        rest = self._encode(self._decoder.decode(None))
        return rest + self._resample(None) + list(self.stream.encode(None))

    def _new_resampler(self) -> Any:
        return av.AudioResampler(self.stream.codec_context.format.name, self._layout, self._rate)

    def _encode(self, frames: list[Any]) -> list[Any]:
        packets: list[Any] = []
        for frame in frames:
            format_ = (frame.format.name, frame.layout.name, frame.sample_rate)
            if self._input not in (None, format_):
                packets += self._resample(None)
                self._resampler = self._new_resampler()
            self._input = format_
            packets += self._resample(frame)
        return packets

    def _resample(self, frame: Any) -> list[Any]:
        pieces = self._resampler.resample(frame)
        return [packet for piece in pieces for packet in self.stream.encode(piece)]


class SubtitleConverter:
    """Converts the packets of one text subtitle stream to another codec, at the same times.

    mp4 and mov cannot show two subtitles at a time. So overlapping subtitles become a sequence, in
    which one has the lines of both while both are to be shown.
    decoder: of the source's stream, used by nobody else.
    """

    def __init__(self, container: Any, codec: str, decoder: Any) -> None:
        self._decoder = decoder
        self._decoder.open(strict=False)
        self.stream = container.add_stream(codec)
        context = self.stream.codec_context
        context.subtitle_header = self._decoder.subtitle_header
        context.time_base = Fraction(1, 1000)
        self.stream.time_base = Fraction(1, 1000)
        self._tick = Fraction(1, 1000)  # of the packets
        self._one_at_a_time = OneAtATime() if codec == "mov_text" else None

    def __call__(self, packet: Any) -> list[Any]:
        subtitles = self._decoder.decode2(packet)
        if subtitles is None or not len(subtitles):
            return []  # mp4 fills the gaps between subtitles with empty ones
        self._tick = packet.time_base
        line = joined([event.ass for event in subtitles])
        if self._one_at_a_time is None or packet.pts is None:
            return [self._encoded(line, packet.pts, packet.duration)]
        end = packet.pts + packet.duration if packet.duration else None
        return self._of_titles(self._one_at_a_time(Title(packet.pts, end, line)))

    def flush(self) -> list[Any]:
        """The packets of the subtitles that are still held."""
        return [] if self._one_at_a_time is None else self._of_titles(self._one_at_a_time.drain())

    def _of_titles(self, titles: list[Title]) -> list[Any]:
        return [
            self._encoded(one.line, one.begin, 0 if one.end is None else one.end - one.begin)
            for one in titles
        ]

    def _encoded(self, line: bytes, begin: int | None, duration: int | None) -> Any:
        out = self.stream.codec_context.encode_subtitle(SubtitleSet.create(line, 0, 0))
        out.stream, out.time_base = self.stream, self._tick
        out.pts = out.dts = begin
        out.duration = duration
        return out


def _rate_for(codec: str, rate: int) -> int:
    """The encoder's lowest rate that is not below the sound's, or else the encoder's highest.

    Cameras have rates such as 11024 Hz, which AAC lacks.
    """
    rates = av.Codec(codec, "w").audio_rates or [rate]
    return min((one for one in rates if one >= rate), default=max(rates))
