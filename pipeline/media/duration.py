"""The length of a video, and a check that a run's start lies within it."""

from fractions import Fraction

import av
from makeup_video.pipeline.errors import UsageError, option
from makeup_video.pipeline.media.input_file import VideoSource, packets_of


def check_start(source: VideoSource, start_seconds: Fraction | None) -> None:
    """Raises UsageError when the video ends before `start_seconds`.

    Seconds count from where a player begins. A container that does not declare its length passes.
    A header may be wrong, so the packets of a video that seems too short are read from its last
    key frame on.
    """
    length = _length_seconds(source)
    if start_seconds is None or length is None or start_seconds < length:
        return
    if not _has_packets_at(source, start_seconds + source.start_seconds):
        raise beyond_end(source, start_seconds, length)


def beyond_end(
    source: VideoSource, start_seconds: Fraction, length_seconds: Fraction
) -> UsageError:
    return UsageError(
        f"{option('start_seconds')} {float(start_seconds):g} s is beyond the end: {source.path} is "
        f"{round(float(length_seconds), 2)} s long"
    )


def _length_seconds(source: VideoSource) -> Fraction | None:
    """The length of all streams together, as the container declares it."""
    container = source.container
    if container.duration is None:
        return None
    end = Fraction((container.start_time or 0) + container.duration, av.time_base)
    return end - source.start_seconds


def _has_packets_at(source: VideoSource, seconds: Fraction) -> bool:
    """True when the video goes on at that time of the container's clock."""
    try:
        again = source.open_again()  # the caller reads on from where it is
        video = again.streams[source.video.index]
        again.seek(int(seconds / source.time_base), stream=video)
        return any(
            packet.pts is not None
            and (packet.pts + (packet.duration or 0)) * packet.time_base > seconds
            for packet in packets_of(again, video)
        )
    except av.FFmpegError:
        return True  # decoding will show
