"""Videos with key frames to be split at, each odd in its own way, and how two videos differ."""

from fractions import Fraction
from functools import partial

import av
from av.subtitles.subtitle import SubtitleSet
from media import add_video, decoded, encode_frames, make_clip, packets_of, tone
from rich_clips import add_titles, chapters_of, titles_of

GROUP = {"g": "12", "bf": "2", "preset": "veryfast"}
MASTER = (
    "master-display=G(13250,34500)B(7500,3000)R(34000,16000)WP(15635,16450)L(10000000,50)"
    ":max-cll=1000,400"
)
_MS = Fraction(1, 1000)


def rich(path):
    """Sound, chapters, tags, a font, and a title that is shown for the whole video."""
    with av.open(str(path), "w") as out:
        video = add_video(out, options=GROUP)
        sound = out.add_stream("aac", rate=48000, layout="stereo")
        sound.metadata["language"] = "ger"
        titles = add_titles(out, "ass" if path.suffix == ".mkv" else "mov_text")
        if path.suffix == ".mkv":
            out.add_attachment("font.ttf", "font/ttf", b"not really a font" * 10)
        out.metadata["title"] = "A video"
        out.set_chapters(
            [
                {"id": n, "start": 700 * n, "end": 700 * (n + 1), "time_base": _MS,
                 "metadata": {"title": str(n)}}
                for n in range(4)
            ]
        )  # fmt: skip
        encode_frames(out, video, range(84))
        tone(out, sound, 2.8)
        event = SubtitleSet.create(b"0,0,Default,,0,0,0,,All along", 0, 2600)
        packet = titles.codec_context.encode_subtitle(event)
        packet.stream, packet.time_base, packet.duration = titles, _MS, 2600
        packet.pts = packet.dts = 100
        out.mux(packet)
    return path


def sound_first(path):
    """Sound that precedes the video in the file, begins later, and is longer."""
    with av.open(str(path), "w") as out:
        sound = out.add_stream("aac", rate=44100, layout="stereo")
        video = add_video(out, options=GROUP)
        tone(out, sound, 4.5, start_seconds=0.3)
        encode_frames(out, video, range(84))
    return path


def broadcast(path):
    """The times begin at one hour."""
    with av.open(str(path), "w") as out:
        video = add_video(out, options=GROUP, time_base=Fraction(1, 90000))
        sound = out.add_stream("aac", rate=48000, layout="stereo")
        encode_frames(out, video, (90000 * 3600 + 3000 * n for n in range(84)))
        tone(out, sound, 2.8, start_seconds=3600)
    return path


def hidden_frames(path, frames=96, options=None, container_options=None):
    """An edit list hides the first half second: a stream copy that begins inside a group."""
    whole = make_clip(path.with_name("long.mp4"), frames=frames, options=options or GROUP)
    with (
        av.open(str(whole)) as container,
        av.open(str(path), "w", container_options=container_options or {}) as out,
    ):
        stream = out.add_stream_from_template(container.streams.video[0], opaque=True)
        for packet in container.demux(video=0):
            if packet.size:
                packet.pts -= round(Fraction(1, 2) / packet.time_base)
                packet.dts -= round(Fraction(1, 2) / packet.time_base)
                packet.stream = stream
                out.mux(packet)
    return path


VARIABLE = [n * 20 + (7 * n * n) % 11 + 3000 * (n >= 40) for n in range(84)]
_clip = partial(make_clip, frames=84, options=GROUP)
VIDEOS = {
    "plain.mp4": partial(_clip, audio="aac"),
    "rich.mkv": rich,
    "rich.mp4": rich,
    "sound_first.mkv": sound_first,
    "sound_first.mp4": sound_first,
    "variable_rate.mp4": partial(_clip, pts=VARIABLE, time_base=Fraction(1, 600)),
    "broadcast.ts": broadcast,
    "begins_early.mkv": partial(_clip, pts=range(-9, 75)),
    "turned.mov": partial(_clip, rotation_degrees=90),
    "open_groups.mp4": partial(
        make_clip, frames=84,
        options={"preset": "veryfast", "x264-params": "open-gop=1:keyint=12:min-keyint=12"},
    ),
    "hdr10.mp4": partial(
        make_clip, codec="hevc", frames=60, pix_fmt="yuv420p10le", colorspace=9, color_range=1,
        color_trc=16, color_primaries=9,
        options={"x265-params": f"log-level=none:keyint=12:min-keyint=12:{MASTER}"},
    ),
    "hidden_frames.mp4": hidden_frames,
    "see_through.mkv": partial(make_clip, codec="ffv1", frames=60, pix_fmt="yuva420p"),
    "all_key.avi": partial(make_clip, codec="mjpeg", frames=60, pix_fmt="yuvj420p"),
}  # fmt: skip


def differences(one, other):
    """Names of the properties that differ, apart from the bytes of the painted video."""
    first, second = _described(one), _described(other)
    return [name for name in first if first[name] != second[name]]


def _described(path):
    """Everything that a file tells a player about its video."""
    with av.open(str(path)) as container:
        video = container.streams.video[0]
        packets = [packet for packet in container.demux(video) if packet.size]
        context = video.codec_context
        found = {
            "streams": [(s.type, getattr(s, "name", None), s.disposition, dict(s.metadata))
                        for s in container.streams],
            "tags": dict(container.metadata),
            "lengths": [(s.duration, s.start_time, s.time_base) for s in container.streams],
            "headers": bytes(context.extradata or b""),
            "codec tag": context.codec_tag,
            "pixel aspect": video.sample_aspect_ratio,
            "rate": (video.average_rate, video.guessed_rate),
            "decoding times": [packet.dts for packet in packets],
            "presentation times": sorted(packet.pts for packet in packets),
            "durations": [packet.duration for packet in packets],
            "attachments": [s.data for s in container.streams.attachments],
            "has titles": bool(container.streams.subtitles),
            "sounds": len(container.streams.audio),
        }  # fmt: skip
    frames = decoded(path)
    found["frame times"] = [frame.pts * frame.time_base for frame in frames]
    found["pictures"] = [
        (f.width, f.height, f.format.name, f.colorspace, f.color_range, f.color_trc,
         f.color_primaries, f.rotation, f.interlaced_frame,
         sorted((d.type.name, bytes(d)) for d in f.side_data if d.type.name in _KEPT))
        for f in frames
    ]  # fmt: skip
    found["sound"] = [packets_of(path, "audio", index) for index in range(found["sounds"])]
    found["chapters"] = chapters_of(path)
    found["titles"] = titles_of(path) if found["has titles"] else None
    return found


_KEPT = ("MASTERING_DISPLAY_METADATA", "CONTENT_LIGHT_LEVEL", "DISPLAYMATRIX")
