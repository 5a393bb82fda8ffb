"""Chooses how a video is decoded and encoded, from its source, its output and the settings."""

from dataclasses import dataclass
from pathlib import Path

from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.errors import UsageError
from makeup_video.pipeline.frames.frame import layout_of
from makeup_video.pipeline.media.codecs import (
    VideoCodec,
    codecs_with,
    container_of,
    encoder_options,
    pick_codec,
)
from makeup_video.pipeline.media.encode import PacketWriter, VideoEncoder
from makeup_video.pipeline.media.hardware import NONE, EncoderNeeds, pick_encoder
from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat, bits_of, pick_pix_fmt
from makeup_video.pipeline.offline.settings import Settings

_LARGE_PX = 6_000_000  # of a frame: between 1440p and 2160p
_MORE_CHROMA = {(1, 1): "4:4:4", (2, 1): "4:2:2"}  # by luma samples per chroma sample
_ANIMATED_PNG = "apng"  # FFmpeg's name of the format
_PROGRESSIVE = 1  # FFmpeg's AV_FIELD_PROGRESSIVE; 0 is unknown, and higher numbers are interlaced


@dataclass(frozen=True, slots=True)
class Encoding:
    """container: FFmpeg's name of the output's muxer.  codec, options: of the encoder.

    frame_px: of the output; before and after side by side have twice the pixels of the source.
    depth: bits per sample; None: as usual for the codec.  sdr: HDR becomes SDR.
    note: how the encoder was chosen, where hardware was asked for; also a warning where few players
    can show the output.
    is_opaque: as in VideoSource.
    """

    container: str
    codec: VideoCodec
    options: dict[str, str]
    frame_px: int
    depth: int | None
    sdr: bool
    note: str = ""
    is_opaque: bool = False

    def convert(self) -> ConvertPixelFormat:
        return ConvertPixelFormat(self.codec, self.depth, sdr=self.sdr, is_opaque=self.is_opaque)

    def encoder(
        self, writer: PacketWriter, source: VideoSource, threads: int | None
    ) -> VideoEncoder:
        """threads: 0 lets the encoder choose; None: as `encoder_threads`."""
        count = encoder_threads(self.codec, self.frame_px, threads)
        return VideoEncoder(writer, source, self.codec, self.options, count, self.note)


def choose_encoding(source: VideoSource, output: Path, settings: Settings) -> Encoding:
    """Raises UsageError for settings that do not fit together, before the output is begun."""
    container = _container_of(source, output)
    becomes_sdr = settings.sdr and source.tags.is_hdr
    deep = not becomes_sdr and (source.bit_depth > 8 or source.tags.is_hdr)
    if settings.bit_depth is not None:
        deep = settings.bit_depth > 8
    codec = pick_codec(settings.codec, container, deep=deep, alpha=source.has_alpha)
    depth = settings.bit_depth
    if depth is None and becomes_sdr:
        depth = min(map(bits_of, codec.pix_fmts))  # 8 bits suffice, but ProRes has no such format
    if depth is not None:
        pick_pix_fmt("yuv420p", codec, depth)  # raises UsageError
    note = ""
    if settings.hardware != NONE:
        codec, note = pick_encoder(codec, settings.hardware, _needs(source, depth, settings))
    note = "; ".join(filter(None, (note, _hardly_played(source, container, codec, depth))))
    options = encoder_options(codec, settings.crf, settings.preset)
    frame_px = source.frame_px * (2 if settings.compare else 1)
    sdr, is_opaque = settings.sdr, source.is_opaque
    return Encoding(container, codec, options, frame_px, depth, sdr, note, is_opaque)


def _container_of(source: VideoSource, output: Path) -> str:
    """Like container_of, but the error for an animated PNG says that the source is one."""
    try:
        return container_of(output)
    except UsageError as error:
        if source.container.format.name == _ANIMATED_PNG:
            error.extend(before=f"{source.path} is an animated PNG: ")
        raise


def _hardly_played(
    source: VideoSource, container: str, codec: VideoCodec, depth: int | None
) -> str:
    """A warning where few players can show the output's chroma, else "". A source in the same codec
    needs none: its owner presumably has a player for it."""
    context = source.video.codec_context
    if not codec.little_chroma or context.codec.name == codec.name:
        return ""
    name = "rgb24" if source.is_opaque else context.pix_fmt or "yuv420p"
    chroma = _MORE_CHROMA.get(_chroma_of(pick_pix_fmt(name, codec, depth)))
    if chroma is None:
        return ""
    others = codecs_with(
        lambda one: (
            container in one.containers and not _MORE_CHROMA.keys() & map(_chroma_of, one.pix_fmts)
        )
    )
    hint = f"; {others} is always 4:2:0" if others else ""
    return f"few players can show {chroma} in {codec.name}{hint}"


def _chroma_of(pix_fmt: str) -> tuple[int, int]:
    return layout_of(pix_fmt).chroma


def _needs(source: VideoSource, depth: int | None, settings: Settings) -> EncoderNeeds:
    """What the video needs of an encoder."""
    context = source.video.codec_context
    width_px = context.width * (2 if settings.compare else 1)
    return EncoderNeeds(
        (width_px, context.height),
        context.pix_fmt or "yuv420p",
        settings.crf,
        settings.preset,
        depth,
        context.field_order > _PROGRESSIVE,
    )


def decoder_threads(wanted: int | None = None) -> int:
    """As many threads as wanted; None: half as many as there are cores.

    FFmpeg would choose one per core and one more, each with pictures in memory. But a video waits
    for the encoder, not for the decoder.
    """
    return max(1, cores() // 2) if wanted is None else wanted


def encoder_threads(codec: VideoCodec, frame_px: int, wanted: int | None = None) -> int:
    """As many threads as wanted; None: one per core for large frames, else the encoder's choice: 0.

    x264 chooses one and a half per core. At 2160p, one per core takes the same CPU time and 75 MB
    less memory.
    """
    if wanted is None and codec.many_threads and frame_px >= _LARGE_PX:
        return cores()
    return wanted or 0
