"""Makes the small, unusual media files that the tests use."""

import threading
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import av
import numpy as np
from av.codec.context import Flags
from av.video.reformatter import ColorRange, VideoReformatter
from makeup_video.pipeline.media.scheduling import open_encoder

ENCODERS = {
    "h264": ("libx264", {"preset": "ultrafast", "crf": "18"}),
    "hevc": ("libx265", {"preset": "ultrafast", "x265-params": "log-level=none"}),
    "vp9": ("libvpx-vp9", {"deadline": "realtime", "cpu-used": "8", "crf": "30"}),
    "av1": ("libsvtav1", {"preset": "12", "crf": "40"}),
    "mpeg4": ("mpeg4", {"qscale": "3"}),
    "ffv1": ("ffv1", {}),
    "prores": ("prores_ks", {}),
    "mjpeg": ("mjpeg", {"qscale": "3"}),
    "qtrle": ("qtrle", {}),
}
# One converter for all pictures: to make another for each takes three times as long as a picture.
_CONVERTER, _CONVERTING = VideoReformatter(), threading.Lock()
# The header that FFmpeg's encoders of text subtitles need before the first title.
ASS_HEADER = b"""[Script Info]
ScriptType: v4.00+
[V4+ Styles]
Format: Name, Fontname, Fontsize, PrimaryColour, SecondaryColour, OutlineColour, BackColour, Bold, \
Italic, Underline, StrikeOut, ScaleX, ScaleY, Spacing, Angle, BorderStyle, Outline, Shadow, \
Alignment, MarginL, MarginR, MarginV, Encoding
Style: Default,Arial,16,&Hffffff,&Hffffff,&H0,&H0,0,0,0,0,100,100,0,0,1,1,0,2,10,10,10,0
[Events]
Format: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text
"""


def picture(index: int, width_px: int, height_px: int, pix_fmt: str = "yuv420p") -> av.VideoFrame:
    """A moving picture with detail: frame `index` of an endless clip, in `pix_fmt`."""
    x, y = np.arange(width_px), np.arange(height_px)[:, None]
    rgb = np.empty((height_px, width_px, 3), np.uint8)
    rgb[..., 0] = (x * 2 + index * 3) % 256
    rgb[..., 1] = (y * 2 + index * 5) % 256
    rgb[..., 2] = (x % 256).astype(np.uint8) + ((y + index * 7) % 256).astype(np.uint8)
    frame = av.VideoFrame.from_ndarray(rgb, format="rgb24")
    if pix_fmt == "rgb24":
        return frame
    with _CONVERTING:
        return _CONVERTER.reformat(frame, format=pix_fmt)


def damage(path: Path) -> None:
    """Blank 400 bytes in the middle of a file."""
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 400] = bytes(400)
    path.write_bytes(data)


def add_video(
    container: Any,
    codec: str = "h264",
    *,
    size_wh: tuple[int, int] = (96, 64),
    pix_fmt: str = "yuv420p",
    rate: Fraction | int = 30,
    time_base: Fraction | None = None,
    options: dict[str, str] | None = None,
    **attributes: Any,
) -> Any:
    """Add a video stream for one of ENCODERS; the attributes are set on its codec context."""
    name, defaults = ENCODERS[codec]
    stream = container.add_stream(name, rate=rate, options={**defaults, **(options or {})})
    stream.width, stream.height = size_wh
    stream.pix_fmt = pix_fmt
    tick = time_base or 1 / Fraction(rate)
    stream.time_base = tick
    stream.codec_context.time_base = tick
    for key, value in attributes.items():
        setattr(stream.codec_context, key, value)
    return stream


def encode_frames(
    container: Any,
    stream: Any,
    pts: Iterable[int],
    *,
    change: Callable[[av.VideoFrame, int], av.VideoFrame] | None = None,
) -> None:
    """Encode and mux one picture per pts (in the stream's time base)."""
    context = stream.codec_context
    tick = context.time_base
    if not context.is_open:
        open_encoder(context)
    for index, value in enumerate(pts):
        frame = picture(index, context.width, context.height, context.pix_fmt)
        frame.pts, frame.time_base = value, tick
        if context.color_range:
            frame.color_range = ColorRange(context.color_range)
        container.mux(stream.encode(change(frame, index) if change else frame))
    container.mux(stream.encode(None))


def tone(
    container: Any,
    stream: Any,
    seconds: float,
    *,
    hertz: float = 440.0,
    start_seconds: float = 0.0,
) -> None:
    """Encode and mux a sine of the given length into an audio stream."""
    rate = stream.codec_context.sample_rate
    start = round(start_seconds * rate)
    layout = stream.codec_context.layout
    step = 1024
    for first in range(0, round(seconds * rate), step):
        t = np.arange(first, first + step) / rate
        wave = (0.2 * np.sin(2 * np.pi * hertz * t)).astype(np.float32)
        samples = np.stack([wave] * layout.nb_channels)
        frame = av.AudioFrame.from_ndarray(samples, format="fltp", layout=layout.name)
        frame.sample_rate = rate
        frame.pts, frame.time_base = start + first, Fraction(1, rate)
        resampled = av.AudioResampler(stream.codec_context.format.name, layout.name, rate)
        for piece in resampled.resample(frame):
            container.mux(stream.encode(piece))
    container.mux(stream.encode(None))


def make_clip(
    path: Path,
    codec: str = "h264",
    *,
    frames: int = 12,
    pts: Sequence[int] | None = None,
    last: int | None = None,
    audio: str | None = None,
    options: dict[str, str] | None = None,
    container_options: dict[str, str] | None = None,
    rotation_degrees: int | None = None,
    **video: Any,
) -> Path:
    """Write a short clip: one video stream, and one audio stream if `audio` names a codec.

    last: the duration of the last frame of `pts`, all other frames last until the next one;
    None: the encoder guesses durations.
    """
    with av.open(str(path), "w", container_options=container_options or {}) as out:
        stream = add_video(out, codec, options=options, **video)
        if rotation_degrees is not None:
            stream.set_display_rotation(rotation_degrees)
        sound = out.add_stream(audio, rate=48000, layout="stereo") if audio else None
        change = None
        if pts is not None and last is not None:
            stream.codec_context.flags |= Flags.frame_duration
            change = _lasting([b - a for a, b in pairwise([*pts, pts[-1] + last])])
        encode_frames(out, stream, pts if pts is not None else range(frames), change=change)
        if sound is not None:
            tick = stream.codec_context.time_base
            tone(out, sound, float((max(pts) if pts else frames) * tick))
    return path


def _lasting(durations: Sequence[int]) -> Callable[[av.VideoFrame, int], av.VideoFrame]:
    """A change for `encode_frames` that gives each frame its duration, in ticks."""

    def change(frame: av.VideoFrame, index: int) -> av.VideoFrame:
        frame.duration = durations[index]
        return frame

    return change


def packets_of(path: Path, kind: str, index: int = 0) -> list[tuple[Fraction | None, bytes]]:
    """(seconds, payload) of every packet of the index-th stream of that kind."""
    with av.open(str(path)) as container:
        stream = [s for s in container.streams if s.type == kind][index]
        return [
            (None if p.pts is None else p.pts * p.time_base, bytes(p))
            for p in container.demux(stream)
            if p.size
        ]


def decoded(path: Path) -> list[av.VideoFrame]:
    """Every decoded frame of the first real video stream (cover art left out)."""
    with av.open(str(path)) as container:
        stream = next(
            s
            for s in container.streams.video
            if not s.disposition & av.stream.Disposition.attached_pic
        )
        return list(container.decode(stream))


def times_of(path: Path) -> list[Fraction]:
    """Exact presentation times of the decoded frames, in seconds."""
    return [frame.pts * frame.time_base for frame in decoded(path)]
