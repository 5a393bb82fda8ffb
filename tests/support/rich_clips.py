"""Clips with subtitles, chapters, cover art, timecode and data, and readers for these."""

from fractions import Fraction

import av
from av.stream import Disposition
from av.subtitles.subtitle import SubtitleSet
from media import ASS_HEADER, add_video, encode_frames, picture, tone

TITLES = [(100, 400, b"Hello, you"), (500, 300, "Grüße — 你好".encode())]


def add_titles(container, codec="mov_text", language="fre"):
    stream = container.add_stream(codec)
    stream.codec_context.subtitle_header = ASS_HEADER
    stream.time_base = Fraction(1, 1000)
    stream.metadata["language"] = language
    return stream


def write_titles(container, stream):
    for start, length, text in TITLES:
        write_title(container, stream, start, length, text)


def write_title(container, stream, start, length, text):
    """start, length: in milliseconds."""
    line = b"0,0,Default,,0,0,0,," + text
    packet = stream.codec_context.encode_subtitle(SubtitleSet.create(line, 0, length))
    packet.stream, packet.time_base = stream, Fraction(1, 1000)
    packet.pts = packet.dts = start
    packet.duration = length
    container.mux(packet)


def titles_of(path):
    """(start ms, length ms, plain text) of the first subtitle stream."""
    with av.open(str(path)) as container:
        stream = container.streams.subtitles[0]
        found = []
        for packet in container.demux(stream):
            if packet.size <= 2:
                continue
            events = stream.codec_context.decode2(packet)
            text = b"".join(rect.dialogue for rect in events)
            ms = [round(n * packet.time_base * 1000) for n in (packet.pts, packet.duration)]
            found.append((*ms, text))
        return found


def rich_clip(path, sound=("aac", "aac"), titles=None):
    """Two audio streams, a subtitle stream, chapters, timecode, tags."""
    with av.open(str(path), "w") as out:
        video = add_video(out)
        if path.suffix in (".mp4", ".mov"):
            video.metadata["timecode"] = "01:02:03:04"
        streams = []
        for language, codec in zip(("eng", "ger"), sound, strict=False):
            stream = out.add_stream(codec, rate=48000, layout="stereo")
            stream.metadata["language"] = language
            streams.append(stream)
        streams[0].disposition = Disposition.default
        streams[1].disposition = Disposition.comment
        text = add_titles(out, titles) if titles else None
        out.metadata.update({"title": "A video", "artist": "Somebody"})
        ms = Fraction(1, 1000)
        out.set_chapters(
            [
                {"id": 1, "start": 0, "end": 500, "time_base": ms, "metadata": {"title": "One"}},
                {"id": 2, "start": 500, "end": 1000, "time_base": ms, "metadata": {"title": "Two"}},
            ]
        )
        encode_frames(out, video, range(30))
        for index, stream in enumerate(streams):
            tone(out, stream, 1.0, hertz=440 + 220 * index)
        if text is not None:
            write_titles(out, text)
    return path


def chapters_of(path):
    with av.open(str(path)) as container:
        return [
            (c["start"] * c["time_base"], c["end"] * c["time_base"], c["metadata"]["title"])
            for c in container.chapters()
        ]


def make_cover(path):
    """Write a clip with a cover larger than the video; returns the cover's JPEG bytes."""
    jpeg = av.CodecContext.create("mjpeg", "w")
    jpeg.width, jpeg.height, jpeg.pix_fmt = 400, 300, "yuvj420p"
    jpeg.time_base = Fraction(1, 25)
    [packet] = jpeg.encode(picture(0, 400, 300, "yuvj420p")) or jpeg.encode(None)
    with av.open(str(path), "w") as out:
        video = add_video(out)
        cover = out.add_mux_stream("mjpeg", width=400, height=300)
        cover.disposition = Disposition.attached_pic
        out.start_encoding()
        packet.stream, packet.pts, packet.dts = cover, 0, 0
        data = bytes(packet)
        out.mux(packet)
        encode_frames(out, video, range(10))
    return data


def klv_clip(path):
    with av.open(str(path), "w") as out:
        video, data = add_video(out), out.add_data_stream("klv")
        data.time_base = Fraction(1, 90000)
        encode_frames(out, video, range(10))
        for index in range(3):
            packet = av.Packet(b"klv payload %d" % index)
            packet.stream, packet.time_base = data, Fraction(1, 90000)
            packet.pts = packet.dts = index * 9000
            out.mux(packet)
    return path
