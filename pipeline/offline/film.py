"""What every run over a film needs: its decoder and its report."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from makeup_video.pipeline.engine.channel import Channel
from makeup_video.pipeline.engine.runner import StageTimes
from makeup_video.pipeline.media.decode import Decoder, StreamCopier
from makeup_video.pipeline.media.encode import VideoEncoder
from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.media.mux import Muxer
from makeup_video.pipeline.offline.encoding import Encoding, decoder_threads
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.settings import Settings


def open_decoder(
    source: VideoSource, encoding: Encoding, copier: StreamCopier, settings: Settings
) -> Decoder:
    """The decoder of the part of the film that the settings keep."""
    return Decoder(
        source,
        encoding.convert(),
        copier,
        start_seconds=settings.start_seconds,
        end_seconds=settings.end_seconds,
        threads=decoder_threads(settings.decoder_threads),
    )


def film_report(
    source: VideoSource, output: Path, decoder: Decoder, encoder: VideoEncoder, muxer: Muxer
) -> Report:
    """The report of a finished film, without what the stages and channels know."""
    stats = decoder.stats
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
        bytes_out=muxer.bytes_out,
    )


def add_times(
    report: Report, times: Mapping[str, StageTimes], channels: Iterable[Channel[Any]]
) -> None:
    """Write the times of the stages and the fill of the channels into the report."""
    report.stages = {name: asdict(one) for name, one in times.items()}
    report.channels = {
        channel.name: {"capacity": channel.capacity, "mean_fill": channel.mean_fill}
        for channel in channels
    }
