"""What every run over a film needs: its codec, its decoder, and its report."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from makeup_video.pipeline.engine.channel import Channel
from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.engine.runner import StageTimes
from makeup_video.pipeline.media.codecs import (
    VideoCodec,
    container_of,
    encoder_options,
    pick_codec,
)
from makeup_video.pipeline.media.decode import Decoder, StreamCopier
from makeup_video.pipeline.media.encode import VideoEncoder
from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.media.mux import Muxer
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat, bits_of, pick_pix_fmt
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.settings import Settings


@dataclass(frozen=True, slots=True)
class Encoding:
    """How a film is written.

    container: FFmpeg's name of it.  options: the encoder's own.  depth: bits per sample; None:
    those usual for the codec.
    """

    container: str
    codec: VideoCodec
    options: dict[str, str]
    depth: int | None


def pick_encoding(source: VideoSource, output: Path, settings: Settings) -> Encoding:
    """The encoding that the settings ask for, or that suits source and output.

    Raises UsageError.
    """
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
        pick_pix_fmt("yuv420p", codec, depth)  # raises UsageError before the output is begun
    return Encoding(container, codec, options, depth)


def open_decoder(
    source: VideoSource, encoding: Encoding, copier: StreamCopier, settings: Settings
) -> Decoder:
    """The decoder of the part of the film that the settings keep."""
    threads = settings.decoder_threads
    return Decoder(
        source,
        ConvertPixelFormat(encoding.codec, encoding.depth, sdr=settings.sdr),
        copier,
        start_seconds=settings.start_seconds,
        end_seconds=settings.end_seconds,
        threads=decoder_threads() if threads is None else threads,
    )


def open_encoder(
    source: VideoSource, encoding: Encoding, muxer: Muxer, settings: Settings
) -> VideoEncoder:
    """The encoder of one output."""
    threads = settings.encoder_threads or 0
    return VideoEncoder(muxer, source, encoding.codec, encoding.options, threads)


def decoder_threads() -> int:
    """Half as many threads as there are cores.

    FFmpeg's own choice is one a core and one more, each with pictures in memory; but a film waits
    for the encoder, not for the decoder.
    """
    return max(1, cores() // 2)


def film_report(
    source: VideoSource,
    output: Path,
    decoder: Decoder,
    encoder: VideoEncoder,
    times: Mapping[str, StageTimes],
    channels: Iterable[Channel[Any]],
) -> Report:
    """The counts of one output of a run that has ended."""
    stats, muxer = decoder.stats, encoder.muxer
    return Report(
        source=str(source.path),
        output=str(output),
        codec=encoder.codec.name,
        frames_in=stats.frames,
        frames_out=muxer.video_packets,
        max_pts_error_seconds=float(encoder.max_pts_error_seconds),
        mended_times=stats.mended_times,
        corrupt_frames=stats.corrupt_frames,
        lost_frames=stats.lost_frames,
        decode_errors=stats.decode_errors,
        truncated=stats.truncated,
        skipped_packets=muxer.skipped_packets,
        damaged=stats.is_damaged or muxer.skipped_packets > 0,
        dropped=muxer.dropped,
        converted=muxer.converted,
        conversions=list(decoder.convert.conversions),
        media_seconds=float(decoder.media_seconds),
        first_packet_unix_seconds=encoder.first_packet_at,
        stages={name: asdict(one) for name, one in times.items()},
        channels={
            channel.name: {"capacity": channel.capacity, "mean_fill": channel.mean_fill}
            for channel in channels
        },
        bytes_out=muxer.bytes_out,
    )
