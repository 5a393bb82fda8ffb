"""What every run over a video needs: its decoder and its report."""

from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from makeup_video.pipeline.engine.channel import Channel
from makeup_video.pipeline.engine.runner import StageTimes
from makeup_video.pipeline.files.output_file import OutputFile
from makeup_video.pipeline.media.decode import Decoder, StreamCopier
from makeup_video.pipeline.media.encode import VideoEncoder
from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.media.mux import Muxer
from makeup_video.pipeline.offline.encoding import Encoding, choose_encoding, decoder_threads
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.settings import Settings

_CHANNEL_FRAMES = 3  # each stage works on this many in turn; more would save hardly any time
_CHANNEL_BYTES = 4_200_000  # of frames that wait: three of 720p, one of 1080p and more

# (frames done, frames expected or None, frames per second of the source)
Progress = Callable[[int, int | None, Fraction], None]


@dataclass(frozen=True, slots=True)
class Video:
    """A video that becomes one output."""

    source: VideoSource
    output: Path
    muxer: Muxer
    decoder: Decoder
    encoder: VideoEncoder

    def report(self) -> Report:
        """See video_report."""
        return video_report(self.source, self.output, self.decoder, self.encoder, self.muxer)


@contextmanager
def begin_video(
    source: VideoSource, output: Path, settings: Settings
) -> Generator[Video, None, None]:
    """Begin the output of a video; an error within the block removes what was begun.

    Raises UsageError, OutputError.
    """
    encoding = choose_encoding(source, output, settings)
    muxer = open_muxer(source, output, encoding, settings, settings.on_whole)
    try:
        decoder = open_decoder(source, encoding, muxer, settings)
        encoder = encoding.encoder(muxer, source, settings.encoder_threads)
        with closing(decoder):
            yield Video(source, output, muxer, decoder, encoder)
    except BaseException:
        if not muxer.is_finished:
            muxer.abort()
        raise


def open_muxer(
    source: VideoSource,
    output: Path,
    encoding: Encoding,
    settings: Settings,
    on_whole: Callable[[], None] | None = None,
) -> Muxer:
    """The muxer of one output of a video. Raises UsageError, OutputError."""
    target = OutputFile(output, source.path, overwrite=settings.overwrite, on_whole=on_whole)
    return Muxer(target, encoding.container, strict=settings.strict)


def open_decoder(
    source: VideoSource, encoding: Encoding, copier: StreamCopier, settings: Settings
) -> Decoder:
    """The decoder of the part of the video that the settings keep."""
    return Decoder(
        source,
        encoding.convert(),
        copier,
        start_seconds=settings.start_seconds,
        end_seconds=settings.end_seconds,
        threads=decoder_threads(settings.decoder_threads),
    )


def channel_frames(source: VideoSource) -> int:
    """How many frames may wait between two threads of a run: large ones would hold much memory."""
    frame_bytes = source.frame_px * (3 if source.bit_depth > 8 else 1.5)
    return max(1, min(_CHANNEL_FRAMES, int(_CHANNEL_BYTES // max(frame_bytes, 1))))


def video_report(
    source: VideoSource, output: Path, decoder: Decoder, encoder: VideoEncoder, muxer: Muxer
) -> Report:
    """The report of a finished video, without the times of stages and the fill of channels.

    source: still open, since by now its name may lead to another file.
    """
    stats = decoder.stats
    return Report(
        source=str(source.path),
        output=str(output),
        codec=encoder.codec.name,
        encoder=encoder.codec.encoder,
        encoder_note=encoder.note,
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
        converted=stats.moved + muxer.converted,
        hardly_played=muxer.hardly_played,
        conversions=list(decoder.convert.conversions),
        media_seconds=float(encoder.span[1] - encoder.span[0]),
        first_packet_unix_seconds=encoder.first_packet_at,
        bytes_in=source.container.size,
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
