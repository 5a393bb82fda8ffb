"""Chooses how a film is decoded and encoded, from its source, its output and the settings."""

from dataclasses import dataclass
from pathlib import Path

from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.media.codecs import (
    VideoCodec,
    container_of,
    encoder_options,
    pick_codec,
)
from makeup_video.pipeline.media.encode import PacketWriter, VideoEncoder
from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat, bits_of, pick_pix_fmt
from makeup_video.pipeline.offline.settings import Settings


@dataclass(frozen=True, slots=True)
class Encoding:
    """container: FFmpeg's name of the output's muxer.  codec, options: of the encoder.

    depth: bits a sample; None: those usual for the codec.  sdr: HDR becomes SDR.
    """

    container: str
    codec: VideoCodec
    options: dict[str, str]
    depth: int | None
    sdr: bool

    def convert(self) -> ConvertPixelFormat:
        return ConvertPixelFormat(self.codec, self.depth, sdr=self.sdr)

    def encoder(
        self, writer: PacketWriter, source: VideoSource, threads: int | None
    ) -> VideoEncoder:
        """threads: 0 or None lets the encoder choose."""
        return VideoEncoder(writer, source, self.codec, self.options, threads or 0)


def choose_encoding(source: VideoSource, output: Path, settings: Settings) -> Encoding:
    """Raises UsageError for settings that do not fit together, before the output is begun."""
    container = container_of(output)
    becomes_sdr = settings.sdr and source.tags.is_hdr
    deep = not becomes_sdr and (source.bit_depth > 8 or source.tags.is_hdr)
    if settings.bit_depth is not None:
        deep = settings.bit_depth > 8
    codec = pick_codec(settings.codec, container, deep=deep, alpha=source.has_alpha)
    options = encoder_options(codec, settings.crf, settings.preset)
    depth = settings.bit_depth
    if depth is None and becomes_sdr:
        depth = min(map(bits_of, codec.pix_fmts))  # 8 bits suffice, but ProRes has no such format
    if depth is not None:
        pick_pix_fmt("yuv420p", codec, depth)  # raises UsageError
    return Encoding(container, codec, options, depth, settings.sdr)


def decoder_threads(wanted: int | None = None) -> int:
    """As many threads as wanted; None: half as many as there are cores.

    FFmpeg's own choice is one a core and one more, each with pictures in memory; but a film waits
    for the encoder, not for the decoder.
    """
    return max(1, cores() // 2) if wanted is None else wanted
