"""Small, unusual videos and animations, made at run time: the seeds of video cases."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
from av.codec.context import Flags
from av.stream import Disposition
from av.subtitles.subtitle import SubtitleSet
from media import add_video, encode_frames, picture, tone
from people import portrait

# Write the same bytes each time: no random identifiers, no dates.
_BITEXACT = {"fflags": "+bitexact"}
# The number of cores must not change the bytes either.
_ONE_THREAD = {
    "hevc": {"x265-params": "log-level=none:pools=1:frame-threads=1"},
    "av1": {"svtav1-params": "lp=1"},
}
_ASS_HEADER = (
    b"[Script Info]\nScriptType: v4.00+\n[V4+ Styles]\nFormat: Name, Fontname, Fontsize\n"
    b"Style: Default,Arial,16\n[Events]\n"
    b"Format: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text\n"
)
_FACE_WH = 144, 168  # its face is 60 px wide
_TITLES = ((20, 150, "One"), (190, 120, "Grüße — 你好"))  # ms, ms, text


@dataclass(frozen=True, kw_only=True)
class Video:
    """One seed: its streams and how they are written.

    streams: "video", "title CODEC" or "sound CODEC", in the order of the file.
    sound_first: audio packets precede video packets.  has_face: the video shows a face to paint.
    """

    codec: str = "h264"
    streams: Sequence[str] = ("video", "sound aac")
    pts: Iterable[int] = range(10)
    rate: int = 48000
    layout: str = "stereo"
    sound_first: bool = False
    chapters: bool = False
    tags: dict[str, str] = field(default_factory=dict)
    video_tags: dict[str, str] = field(default_factory=dict)
    rotation_degrees: int = 0
    cover: bool = False
    attachment: bool = False
    container: dict[str, str] = field(default_factory=dict)
    options: dict[str, str] = field(default_factory=dict)
    interlaced: bool = False
    has_face: bool = False
    video: dict[str, Any] = field(default_factory=dict)

    def write(self, path: Path) -> None:
        """Raises FFmpeg's error or ValueError where this build cannot write the video."""
        with av.open(str(path), "w", container_options={**_BITEXACT, **self.container}) as out:
            added = [self._add(out, text) for text in self.streams]
            if self.attachment:
                out.add_attachment("font.ttf", "font/ttf", b"not really a font" * 10)
            cover = self._add_cover(out) if self.cover else None
            out.metadata.update(self.tags)
            if self.chapters:
                out.set_chapters(_chapters())
            if cover is not None:
                out.mux_one(cover)
            for text, stream in sorted(zip(self.streams, added, strict=True), key=self._turn):
                self._fill(out, text, stream)

    def _turn(self, pair: tuple[str, Any]) -> int:
        order = ("sound", "video", "title") if self.sound_first else ("video", "sound", "title")
        return order.index(pair[0].split()[0])

    def _add(self, out: Any, text: str) -> Any:
        kind, _, codec = text.partition(" ")
        if kind == "video":
            return self._add_video(out)
        if kind == "sound":
            stream = out.add_stream(codec, rate=self.rate, layout=self.layout)
            stream.codec_context.flags |= Flags.bitexact
            stream.metadata["language"] = "eng"
            return stream
        stream = out.add_stream(codec)
        stream.codec_context.subtitle_header = _ASS_HEADER
        stream.time_base = Fraction(1, 1000)
        stream.metadata["language"] = "fre"
        return stream

    def _add_video(self, out: Any) -> Any:
        options = {**_ONE_THREAD.get(self.codec, {}), **self.options}
        size = {"size_wh": _FACE_WH} if self.has_face else {}
        stream = add_video(out, self.codec, options=options, **{**size, **self.video})
        context = stream.codec_context
        context.thread_count = 1
        context.flags |= Flags.bitexact
        if self.interlaced:
            context.flags |= Flags.interlaced_dct | Flags.interlaced_me
        stream.metadata.update(self.video_tags)
        if self.rotation_degrees:
            stream.set_display_rotation(self.rotation_degrees)
        return stream

    def _fill(self, out: Any, text: str, stream: Any) -> None:
        pts = list(self.pts)
        seconds = float((pts[-1] + 1) * (self.video.get("time_base") or Fraction(1, 30)))
        if text == "video":
            encode_frames(out, stream, pts, change=_face if self.has_face else None)
        elif text.startswith("sound"):
            tone(out, stream, seconds)
        else:
            _write_titles(out, stream)

    @staticmethod
    def _add_cover(out: Any) -> Any:
        stream = out.add_mux_stream("mjpeg", width=48, height=32)
        stream.disposition = Disposition.attached_pic
        packet = av.Packet(_jpeg())
        packet.stream, packet.pts, packet.dts = stream, 0, 0
        return packet


def _face(frame: av.VideoFrame, index: int) -> av.VideoFrame:
    """A portrait in place of the picture, moved a little from frame to frame."""
    small = cv2.resize(portrait(), _FACE_WH, interpolation=cv2.INTER_AREA)
    moved = np.ascontiguousarray(np.roll(small, index, axis=1))
    face = av.VideoFrame.from_ndarray(moved, format="rgb24").reformat(format=frame.format.name)
    face.pts, face.time_base = frame.pts, frame.time_base
    return face


def _jpeg() -> bytes:
    encoder = av.CodecContext.create("mjpeg", "w")
    encoder.width, encoder.height, encoder.pix_fmt = 48, 32, "yuvj420p"
    encoder.time_base, encoder.flags = Fraction(1, 30), encoder.flags | Flags.bitexact
    frame = picture(3, 48, 32, "yuvj420p")
    frame.pts = 0
    return b"".join(bytes(packet) for packet in [*encoder.encode(frame), *encoder.encode(None)])


def _chapters() -> list[dict[str, Any]]:
    ms = Fraction(1, 1000)
    times = ((0, 150), (150, 330))
    return [
        {"id": 1 + n, "start": a, "end": b, "time_base": ms, "metadata": {"title": f"Part {n}"}}
        for n, (a, b) in enumerate(times)
    ]


def _write_titles(out: Any, stream: Any) -> None:
    for start, length, text in _TITLES:
        line = b"0,0,Default,,0,0,0,," + text.encode()
        packet = stream.codec_context.encode_subtitle(SubtitleSet.create(line, 0, length))
        packet.stream, packet.time_base = stream, Fraction(1, 1000)
        packet.pts = packet.dts = start
        packet.duration = length
        out.mux(packet)


def _write_plain(path: Path, encoder: str, pix_fmt: str, rate: int = 10) -> None:
    """A bare animation: no sound, no tags, an encoder that tests/media does not know."""
    with av.open(str(path), "w", container_options=_BITEXACT) as out:
        stream = out.add_stream(encoder, rate=rate)
        stream.width, stream.height, stream.pix_fmt = 64, 48, pix_fmt
        stream.codec_context.flags |= Flags.bitexact
        for index in range(8):
            frame = _greys(index) if pix_fmt == "pal8" else picture(index, 64, 48, pix_fmt)
            frame.pts, frame.time_base = index, Fraction(1, rate)
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))


def _greys(index: int) -> av.VideoFrame:
    """A frame with a palette, as GIF requires."""
    grey = np.mgrid[0:48, 0:64].sum(0) * 2 + 5 * index
    palette = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 4, axis=1)
    palette[:, 0] = 255
    return av.VideoFrame.from_ndarray((grey.astype(np.uint8), palette), format="pal8")


_B_FRAMES = {"preset": "veryfast", "bf": "2", "g": "6"}
_TEN_BITS = {"pix_fmt": "yuv420p10le"}
_LATE = {"time_base": Fraction(1, 600)}

VIDEOS: dict[str, Video] = {
    "h264_aac.mp4": Video(has_face=True, options=_B_FRAMES, tags={"title": "A clip", "genre": "x"}),
    "sound_first.mp4": Video(streams=("sound aac", "video"), sound_first=True),
    "late_edit.mp4": Video(options=_B_FRAMES, video=_LATE, pts=range(700, 900, 20)),
    "vfr_turned.mp4": Video(
        video={**_LATE, "size_wh": (98, 66)}, pts=(0, 20, 30, 90, 130, 131, 200),
        rotation_degrees=90,
    ),
    "hevc_10_bit.mp4": Video(has_face=True, codec="hevc", video=_TEN_BITS),
    "h264_10_bit.mp4": Video(has_face=True, video=_TEN_BITS, options={"g": "4"}),
    "fragments.mp4": Video(
        has_face=True, options={"g": "4"},
        container={"movflags": "frag_keyframe+empty_moov+default_base_moof"},
    ),
    "two_sounds.mp4": Video(
        has_face=True, streams=("video", "sound aac", "sound ac3", "title mov_text")
    ),
    "chapters.mp4": Video(
        chapters=True, tags={"title": "Parts", "own_tag": "x"},
        container={"movflags": "faststart+use_metadata_tags"},
    ),
    "cover.mp4": Video(cover=True),
    "odd_444.mp4": Video(video={"size_wh": (65, 49), "pix_fmt": "yuv444p"}, streams=("video",)),
    "prores.mov": Video(
        codec="prores", video={"pix_fmt": "yuv422p10le"}, streams=("video", "sound pcm_s16le"),
        pts=range(4), video_tags={"timecode": "01:02:03:04"},
    ),
    "prores_alpha.mov": Video(
        codec="prores", video={"pix_fmt": "yuva444p10le"}, options={"profile": "4444"},
        streams=("video",), pts=range(4),
    ),
    "timecode.mov": Video(video_tags={"timecode": "10:00:00:00"}, streams=("video", "sound alac")),
    "qtrle_alpha.mov": Video(
        codec="qtrle", video={"pix_fmt": "argb"}, streams=("video",), pts=range(3)
    ),
    "ffv1.mkv": Video(
        codec="ffv1", video={"pix_fmt": "yuv422p10le"}, streams=("video", "sound flac"),
        pts=range(6),
    ),
    "title_first.mkv": Video(streams=("title subrip", "sound libopus", "video"), chapters=True),
    "ass_font.mkv": Video(
        has_face=True, streams=("video", "sound libmp3lame", "title ass"), attachment=True,
        options=_B_FRAMES,
    ),
    "fields.mkv": Video(interlaced=True, options={"preset": "veryfast", "x264-params": "tff=1"}),
    "hevc_pcm.mkv": Video(codec="hevc", streams=("video", "sound pcm_s24le"), layout="mono"),
    "two_videos.mkv": Video(streams=("video", "sound ac3", "video"), pts=range(8)),
    "vp9.webm": Video(
        has_face=True, codec="vp9", streams=("video", "sound libopus"), options={"g": "5"}
    ),
    "vp9_alpha.webm": Video(codec="vp9", video={"pix_fmt": "yuva420p"}, streams=("video",)),
    "webvtt.webm": Video(codec="vp9", streams=("video", "sound libopus", "title webvtt")),
    "av1.webm": Video(codec="av1", streams=("video",)),
    "mpeg4.avi": Video(codec="mpeg4", streams=("video", "sound libmp3lame")),
    "mjpeg.avi": Video(
        codec="mjpeg", video={"pix_fmt": "yuvj420p"}, streams=("video", "sound pcm_s16le"),
    ),
    "h264_b.avi": Video(options=_B_FRAMES, streams=("video", "sound ac3")),
    "h264_aac.ts": Video(has_face=True, options={"g": "5"}),
    "two_sounds.ts": Video(streams=("sound mp2", "video", "sound aac"), sound_first=True),
    "mpeg4.flv": Video(streams=("video", "sound libmp3lame"), rate=44100),
    "sound_first.flv": Video(streams=("sound aac", "video"), sound_first=True),
    "h264.mxf": Video(streams=("video", "sound pcm_s16le"), video={"rate": 25}, options={"g": "6"}),
    "mpeg4.nut": Video(codec="mpeg4", streams=("video", "sound pcm_s16le")),
    "bare.h264": Video(streams=("video",), options={"g": "5"}),
    "bare.ivf": Video(codec="vp9", streams=("video",)),
}  # fmt: skip

ANIMATIONS: dict[str, Callable[[Path], None]] = {
    "animation.gif": partial(_write_plain, encoder="gif", pix_fmt="pal8"),
    "animation.apng": partial(_write_plain, encoder="apng", pix_fmt="rgba"),
    "mpeg2.mpg": partial(_write_plain, encoder="mpeg2video", pix_fmt="yuv420p", rate=25),
    "mpeg2.mxf": partial(_write_plain, encoder="mpeg2video", pix_fmt="yuv422p", rate=25),
    "wmv.asf": partial(_write_plain, encoder="wmv2", pix_fmt="yuv420p", rate=25),
    "flv1.flv": partial(_write_plain, encoder="flv", pix_fmt="yuv420p", rate=25),
    "huffyuv.avi": partial(_write_plain, encoder="huffyuv", pix_fmt="rgb24", rate=25),
}

WRITERS: dict[str, Callable[[Path], None]] = {
    **{name: video.write for name, video in VIDEOS.items()},
    **ANIMATIONS,
}
