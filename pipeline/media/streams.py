"""What an output container can hold of a source's streams and tags, and in which form."""

import io
from fractions import Fraction
from typing import Any

import av
from av.stream import Discard, Disposition
from makeup_video.pipeline.media.codecs import APPLE_HEVC, MATROSKA, MP4
from makeup_video.pipeline.media.input_file import VideoSource, is_cover, lacks_format

# Facts about the source file that do not hold for the output; muxers write their own.
OWN_TAGS = {"major_brand", "minor_version", "compatible_brands", "encoder", "duration", "bps"}
# The keys of mp4's ordinary tag list; any other key needs its list of keys and values.
MP4_TAGS = {
    "title", "artist", "album_artist", "composer", "album", "date", "comment", "genre",
    "copyright", "grouping", "lyrics", "description", "synopsis", "show", "episode_id", "network",
    "keywords", "episode_sort", "season_number", "media_type", "hd_video", "gapless_playback",
    "compilation", "rating", "track", "disc", "tmpo", "creation_time", "timecode", "location",
    "author", "encoded_by",
}  # fmt: skip
# Some languages have two codes in ISO 639-2, of which QuickTime knows only the second one here.
_QUICKTIME_LANGUAGES = {
    "fre": "fra", "deu": "ger", "nld": "dut", "swe": "sve", "zho": "chi", "ell": "gre",
    "isl": "ice", "ron": "rum", "slk": "slo", "ces": "cze", "msa": "may",
}  # fmt: skip
# Marks of a stream that a container cannot hold; FFmpeg's muxers leave them out.
_UNSAID = {
    "mp4": Disposition.original,
    "mov": Disposition.dub | Disposition.original | Disposition.comment | Disposition.forced
    | Disposition.hearing_impaired | Disposition.visual_impaired | Disposition.descriptions,
    "webm": Disposition.dub | Disposition.original | Disposition.comment
    | Disposition.hearing_impaired | Disposition.visual_impaired,
}  # fmt: skip
_ANY_DATA = bytes(8)  # stands for the packet of a stream of data that has not begun
_LEAST_TICKS = 10_000  # per second, of the clock of edit lists
_USUAL_LAYOUTS = {1: "mono", 2: "stereo", 3: "2.1", 4: "quad", 5: "5.0", 6: "5.1", 8: "7.1"}
_MOST = 1 << 32  # Matroska's numbers are smaller


def shown_wh(video: Any, source: VideoSource) -> tuple[int, int] | Fraction | None:
    """The size at which a video of non-square pixels is shown; None for square pixels.

    Where the width would not be a whole number of pixels: the ratio of width to height.
    """
    aspect = source.video.sample_aspect_ratio
    if not aspect or aspect == 1:
        return None
    context = video.codec_context
    width, height = context.width * Fraction(aspect), int(context.height)
    if width.denominator == 1 and width < _MOST:
        return int(width), height
    ratio: Fraction = width / height
    if max(ratio.as_integer_ratio()) < _MOST:
        return ratio
    return min(max(1, round(width)), _MOST - 1), height


def tags(holder: Any, container_format: str) -> dict[str, str]:
    """The metadata of a file or a stream that holds for the output, spelled for its container."""
    kept, is_track = {}, hasattr(holder, "index")
    for key, value in holder.metadata.items():
        plain = key.lower()
        if plain in OWN_TAGS or plain.startswith(("number_of_", "_statistics_", "bps-")):
            continue
        if plain == "timecode" and container_format in MP4:
            key = plain  # Matroska spells it in capitals; mp4 makes its timecode stream from it
        if plain == "name" and is_track and "title" not in holder.metadata:
            key = "title"  # mp4's demuxer says "name", but muxers take a title only as "title"
        if plain == "language" and container_format == "mov":
            value = _QUICKTIME_LANGUAGES.get(value, value)
        kept[key] = value
    return kept


def container_options(
    source: VideoSource, container_format: str
) -> tuple[dict[str, str], list[str]]:
    """(options of the output's muxer, what the output cannot hold because of them)."""
    if container_format in MATROSKA:
        # Without this Matroska's muxer would move everything later when an AAC packet begins before
        # 0, although its blocks can hold negative times.
        return {"avoid_negative_ts": "disabled"}, []
    ticks = source.time_base.denominator
    flags, dropped = "+faststart", []
    if odd := sorted(key for key in tags(source.container, container_format) if _is_odd(key)):
        if container_format == "mp4" and any(map(is_cover, source.container.streams)):
            dropped.append(f"tags {', '.join(odd)}: mp4 holds them or cover art, not both")
        else:
            flags += "+use_metadata_tags"
    # Ticks of streams are as fine as the source's, so that times are exact. Edit lists, which place
    # the sound, have ticks that divide these evenly and are at most a tenth of a millisecond long.
    finer = -(-_LEAST_TICKS // ticks)
    options = {
        "movflags": flags,
        "video_track_timescale": str(ticks),
        "movie_timescale": str(ticks * finer),
    }
    return options, dropped


def _is_odd(key: str) -> bool:
    """True for a tag that only mp4's list of keys and values can hold, not its ordinary tags."""
    return key.lower() not in MP4_TAGS


def label_of(stream: Any) -> str:
    """A stream of the source in messages, such as "audio #1 (aac)"."""
    return f"{stream.type} #{stream.index} ({codec_name(stream)})"


def codec_name(stream: Any) -> str:
    """FFmpeg's name of a stream's codec; PyAV has none where FFmpeg has no decoder."""
    return str(getattr(stream, "name", None) or "unknown codec")


def is_implied(stream: Any, source: VideoSource) -> bool:
    """True for streams that mp4 and mov make anew from what is copied: chapter titles, timecode."""
    if stream.type != "data":
        return False
    # the demuxer has read a stream of chapters itself, and marks it as not to be read again
    is_chapters = stream.discard == Discard.all and bool(source.container.chapters())
    return is_chapters or ("timecode" in source.video.metadata and "timecode" in stream.metadata)


def mystery(stream: Any) -> str | None:
    """Why the content of a stream is unknown; None for streams that are known well enough."""
    if stream.type in ("data", "attachment"):
        return None
    if stream.codec_context is None:
        return "this build of FFmpeg has no decoder for it, so it cannot be copied either"
    if lacks_format(stream):
        return "it begins so late, or is so damaged, that its format is not known"
    return None


def refusal(stream: Any, container_format: str, first_packet: Any | None) -> str | None:
    """Why the container cannot hold the stream as it is; None when it can.

    The only sure way to find out is to write a file with the stream into memory: some muxers
    refuse only the first packet, or the whole file when it is closed. mp4 and mov even take data
    for which they have no sample description, and then write a track that nobody can read, or none.
    """
    # these muxers take such streams and write nothing
    if is_cover(stream) and container_format == "mov":
        return "mov has no place for cover art"
    if stream.type == "attachment" and container_format == "webm":
        return "webm has no place for attachments"
    written = io.BytesIO()
    trial = av.open(written, "w", format=container_format)
    try:
        copy = copy_stream(trial, stream)
        copy.disposition = stream.disposition
        trial.start_encoding()
        packet = _trial_packet(stream, first_packet)
        if packet is not None:
            packet.stream = copy
            trial.mux_one(packet)
        trial.close()
        is_mp4_data = container_format in MP4 and stream.type == "data"
        if is_mp4_data and not _has_data(written.getvalue()):
            return f"{container_format} cannot hold it"
    except (av.FFmpegError, ValueError, RuntimeError):
        return f"{container_format} cannot hold it"
    return None


def _trial_packet(stream: Any, first_packet: Any | None) -> Any | None:
    """A copy of the stream's first packet, at time 0; None before the stream has begun.

    The first packet of data, such as a cue, may come at any time, so another stands for it.
    """
    if first_packet is None and stream.type != "data":
        return None
    packet = av.Packet(_ANY_DATA if first_packet is None else bytes(first_packet))
    packet.time_base = stream.time_base if first_packet is None else first_packet.time_base
    packet.duration = 1 if first_packet is None else first_packet.duration
    packet.pts = packet.dts = 0
    packet.is_keyframe = True
    return packet


def _has_data(file: bytes) -> bool:
    """True when a file in memory holds a stream of data of a known kind."""
    with av.open(io.BytesIO(file)) as container:
        return any(
            stream.type == "data" and getattr(stream, "name", None) for stream in container.streams
        )


def lost_marks(stream: Any, container_format: str) -> str | None:
    """A line for the marks of a stream, such as "forced", that the container cannot hold."""
    lost = stream.disposition & _UNSAID.get(container_format, Disposition(0))
    if not lost:
        return None
    names = ", ".join(str(mark.name).replace("_", " ") for mark in lost)
    return f"{label_of(stream)}: {container_format} cannot mark it as {names}"


def copy_stream(container: Any, stream: Any) -> Any:
    """Add a stream to `container` that takes the packets of `stream` unchanged."""
    copy = container.add_stream_from_template(stream, opaque=True)
    if stream.name == "hevc" and container.format.name in MP4 and _has_header(stream):
        copy.codec_context.codec_tag = APPLE_HEVC
    if stream.type == "audio":
        layout = stream.codec_context.layout
        # Matroska does not declare the channel layout of PCM, and mp4 needs it
        if layout.name.endswith("channels") and layout.nb_channels in _USUAL_LAYOUTS:
            copy.codec_context.layout = _USUAL_LAYOUTS[layout.nb_channels]
    return copy


def _has_header(stream: Any) -> bool:
    """True when an HEVC stream's parameter sets are in its header, as "hvc1" promises."""
    header = bytes(stream.codec_context.extradata or b"")
    if header[:1] == b"\x01":
        # hvcC: ISO/IEC 14496-15, 8.3.3.1.2; byte 22 counts the arrays of sets
        return len(header) > 22 and header[22] > 0
    return len(header) > 0  # as in mpegts: the sets themselves
