"""The video codecs and containers of outputs, and the choice of a codec for a source.

A new codec is one row of CODECS. The module is imported for the command's help text, so it loads no
large library.
"""

import os
import re
from collections.abc import Callable
from typing import NamedTuple

from makeup_video.pipeline.errors import UsageError, closest, option

CONTAINERS = {
    ".mp4": "mp4",
    ".m4v": "mp4",
    ".mov": "mov",
    ".mkv": "matroska",
    ".webm": "webm",
}
MATROSKA = ("matroska", "webm")  # one format, two names
MP4 = ("mp4", "mov")  # almost one format

# HEVC in mp4 and mov has two names. Apple's players need "hvc1", which promises that the parameter
# sets are in the header alone; FFmpeg writes the other, "hev1".
APPLE_HEVC = "hvc1"


class HdrParameters(NamedTuple):
    """How an encoder's library spells static HDR10 metadata.

    mastering_display, content_light: the names of the library's parameters.
    in_units: True: chromaticity counts in 1/50000 and luminance in 1/10000 cd/m2, as in the SEI
    message of SMPTE ST 2086. False: both are plain numbers.
    """

    mastering_display: str
    content_light: str
    in_units: bool


class VideoCodec(NamedTuple):
    """A video codec for outputs, and the properties of its encoder.

    name: the one that users choose.  also: other names for the codec.  encoder: FFmpeg's name.
    containers: FFmpeg's names of the muxers.
    pix_fmts: the pixel formats that we hand to the encoder.
    crf: (lowest, highest, default); None if the encoder has no crf.
    presets: the choices; None if the encoder has no presets.  preset: the default.
    depth: bits per sample unless the user asks for others; None: as many as the source has.
    interlaced: the encoder can keep fields.  whole_chroma: it refuses odd sizes in 4:2:0.
    full_range: its streams can declare samples of full range.
    memory_mb_per_mpx: memory of one more encoder at the default preset, in MB per megapixel of a
    frame; most of it holds the frames of the look-ahead.
    options: (crf, preset) -> the encoder's own options.
    tag: the codec's name in mp4 and mov; None: FFmpeg's choice.
    transparent_in: the containers in which transparency is kept.
    parameters: the option that hands name=value parameters to the encoder's library.
    quiet: parameters that stop the library from printing.  quiet_environment: (variable, value)
    pairs for a library that reads its log level from the environment.
    bottom_first: the parameter for videos that show the bottom field first.
    hdr: None if the encoder cannot carry static HDR10 metadata.  captions: it can carry closed
    captions.  stereo: it can carry how the views of stereo 3D are packed.
    live_preset: fast enough for a live recording; None for codecs that live recordings never use.
    live_options: (option, value) pairs for live recordings, so that packets come out in order and
    without delay.
    many_threads: the encoder starts more threads than there are cores, each with its own pictures.
    is_hardware: the encoder runs on a graphics chip, see hardware.py.
    handed: (our pixel format, the encoder's) pairs, where the encoder takes another order of
    samples.
    device: FFmpeg's type of the device that pictures are sent to.
    little_chroma: few players can show this codec with more chroma than 4:2:0.
    """

    name: str
    encoder: str
    containers: tuple[str, ...]
    pix_fmts: tuple[str, ...]
    crf: tuple[int, int, int] | None
    presets: tuple[str, ...] | None
    preset: str
    depth: int | None
    interlaced: bool
    whole_chroma: bool
    memory_mb_per_mpx: int
    options: Callable[[int, str], dict[str, str]]
    tag: str | None = None
    transparent_in: tuple[str, ...] = ()
    parameters: str = ""
    quiet: tuple[str, ...] = ()
    quiet_environment: tuple[tuple[str, str], ...] = ()
    bottom_first: tuple[str, ...] = ()
    hdr: HdrParameters | None = None
    captions: bool = False
    stereo: bool = False
    live_preset: str | None = None
    live_options: tuple[tuple[str, str], ...] = ()
    also: tuple[str, ...] = ()
    many_threads: bool = False
    full_range: bool = True
    is_hardware: bool = False
    handed: tuple[tuple[str, str], ...] = ()
    device: str | None = None
    little_chroma: bool = False


_X26X_PRESETS = (
    "ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow", "slower", "veryslow",
)  # fmt: skip
_LIMITED = ("yuv420p", "yuv422p", "yuv444p")
_FULL = ("yuvj420p", "yuvj422p", "yuvj444p")
_TEN_BITS = ("yuv420p10le", "yuv422p10le", "yuv444p10le")
_TWELVE_BITS = ("yuv420p12le", "yuv422p12le", "yuv444p12le")

# Phones, browsers and television sets play only 8-bit H.264, so H.264 gets 8 bits, and RGB becomes
# 4:2:0.
# At their default crfs all codecs have about the luma PSNR of H.264 at 18, which is visually
# lossless at normal size. Each default preset encodes 720p30 in real time on two cores.
CODECS = {
    codec.name: codec
    for codec in (
        VideoCodec(
            "h264", "libx264", ("mp4", "mov", "matroska"),
            (*_LIMITED, *_FULL, "nv12", *_TEN_BITS),
            crf=(0, 51, 18), presets=_X26X_PRESETS, preset="veryfast", depth=8,
            interlaced=True, whole_chroma=True,
            memory_mb_per_mpx=130,
            options=lambda crf, preset: {"crf": str(crf), "preset": preset},
            parameters="x264-params", captions=True, stereo=True,
            bottom_first=("bff=1",),  # x264 opens with the top field first
            hdr=HdrParameters("mastering-display", "cll", in_units=True),
            live_preset="superfast", live_options=(("bf", "0"),),
            many_threads=True, little_chroma=True,
            also=("x264", "libx264", "avc", "avc1"),
        ),
        VideoCodec(
            "hevc", "libx265", ("mp4", "mov", "matroska"),
            (*_LIMITED, *_FULL, *_TEN_BITS, *_TWELVE_BITS),
            crf=(0, 51, 18), presets=_X26X_PRESETS, preset="superfast", depth=None,
            interlaced=False, whole_chroma=True,
            memory_mb_per_mpx=170,
            options=lambda crf, preset: {"crf": str(crf), "preset": preset, "a53cc": "1"},
            tag=APPLE_HEVC, captions=True,
            parameters="x265-params", quiet=("log-level=none",),
            hdr=HdrParameters("master-display", "max-cll", in_units=True),
            little_chroma=True,
            also=("h265", "x265", "libx265", "hvc1"),
        ),
        VideoCodec(
            "av1", "libsvtav1", ("mp4", "matroska", "webm"), ("yuv420p", "yuv420p10le"),
            crf=(1, 63, 26), presets=tuple(str(n) for n in range(14)), preset="8", depth=None,
            interlaced=False, whole_chroma=False,
            memory_mb_per_mpx=410,
            options=lambda crf, preset: {"crf": str(crf), "preset": preset},
            parameters="svtav1-params", quiet_environment=(("SVT_LOG", "-1"),),
            hdr=HdrParameters("mastering-display", "content-light", in_units=False),
            also=("svt-av1", "libsvtav1"),
        ),
        VideoCodec(
            "vp9", "libvpx-vp9", ("mp4", "matroska", "webm"), (*_LIMITED, "yuva420p"),
            crf=(0, 63, 24), presets=tuple(str(n) for n in range(9)), preset="6", depth=None,
            interlaced=False, whole_chroma=False,
            memory_mb_per_mpx=115,
            options=lambda crf, preset: {
                "crf": str(crf), "cpu-used": preset, "deadline": "realtime", "row-mt": "1",
                "tile-columns": "2", "auto-alt-ref": "0", "lag-in-frames": "0",
            },
            transparent_in=("webm", "matroska"),
            live_preset="8",
            also=("vpx-vp9", "libvpx-vp9"),
        ),
        VideoCodec(
            "ffv1", "ffv1", ("matroska",),
            (*_LIMITED, *_TEN_BITS, *_TWELVE_BITS, "yuva420p", "yuva422p", "yuva444p",
             "yuva420p10le", "yuva422p10le", "yuva444p10le", "yuva422p12le", "yuva444p12le"),
            crf=None, presets=None, preset="", depth=None,
            interlaced=True, whole_chroma=False,
            memory_mb_per_mpx=65,
            # FFmpeg chooses the number of slices: four, unless an odd size does not allow them
            options=lambda crf, preset: {"level": "3", "slicecrc": "1"},
            transparent_in=("matroska",),
        ),
        VideoCodec(
            "prores", "prores_ks", ("mov", "matroska"),
            ("yuv422p10le", "yuv444p10le", "yuva444p10le"),
            crf=None, presets=("proxy", "lt", "standard", "hq", "4444", "4444xq"), preset="",
            depth=None, interlaced=True, whole_chroma=False,
            memory_mb_per_mpx=35,
            options=lambda crf, preset: {"profile": preset} if preset else {},
            transparent_in=("mov",), full_range=False,
            also=("prores_ks", "apple prores"),
        ),
    )
}  # fmt: skip
PLAYS_EVERYWHERE = CODECS["h264"]  # in browsers, receivers and programs that read cameras


def container_of(path: str | os.PathLike[str]) -> str:
    """FFmpeg's muxer name for an output path. Raises UsageError for any other extension."""
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    if suffix not in CONTAINERS:
        is_bare = os.path.basename(path).lower() in CONTAINERS  # a hidden file
        raise UsageError(
            f"{option('output')} must end in {', '.join(CONTAINERS)} for a video or a GIF, got "
            f"{os.fspath(path)!r}{' without a name before it' if is_bare else ''}"
        )
    return CONTAINERS[suffix]


def pick_codec(name: str | None, container: str, *, deep: bool, alpha: bool) -> VideoCodec:
    """The codec that was asked for, or the one that suits the source best in this container.

    deep: the source has more than 8 bits, or is HDR.  alpha: it has transparency.
    Raises UsageError when there is no such codec, and when the container cannot hold it.
    """
    if name is None:
        return _default_codec(container, deep=deep, alpha=alpha)
    codec = _codec_of(name)
    if container not in codec.containers:
        fitting = codecs_with(lambda other: container in other.containers)
        raise UsageError(f"{container} does not hold {codec.name}; use {option('codec')} {fitting}")
    return codec


def _codec_of(name: str) -> VideoCodec:
    """The codec that has this name: "H.265" and "x265" both mean hevc. Raises UsageError."""
    named = {_plain(word): codec for codec in CODECS.values() for word in (codec.name, *codec.also)}
    codec = named.get(_plain(name))
    if codec is None:
        close = closest(_plain(name), named)
        meant = f": did you mean {named[close].name}?" if close else ""
        raise UsageError(
            f"{option('codec')} must be one of {', '.join(CODECS)}, got {name!r}{meant}"
        )
    return codec


def _plain(name: str) -> str:
    """A codec's name in lower case, without separators: "H.264" becomes "h264"."""
    return re.sub(r"[\s._-]+", "", name).lower()


def _default_codec(container: str, *, deep: bool, alpha: bool) -> VideoCodec:
    if alpha:
        for codec in CODECS.values():
            if container in codec.transparent_in:
                return codec
    if container == "webm":
        return CODECS["av1" if deep else "vp9"]
    return CODECS["hevc" if deep else "h264"]


def codecs_with(fits: Callable[[VideoCodec], bool]) -> str:
    """The names of the codecs that fit, for messages: "h264, hevc or av1"; "" where none does."""
    *names, final = [codec.name for codec in CODECS.values() if fits(codec)] or [""]
    return f"{', '.join(names)} or {final}" if names else final


def encoder_options(codec: VideoCodec, crf: int | None, preset: str | None) -> dict[str, str]:
    """The encoder's options for a crf and a preset; None: our default.

    Raises UsageError for values that the codec does not have.
    """
    if crf is not None:
        if codec.crf is None:
            raise UsageError(f"{codec.name} has no {option('crf')}: leave it out")
        low, high, _ = codec.crf
        if not low <= crf <= high:
            raise UsageError(
                f"{option('crf')} must be in {low}..{high} for {codec.name}, got {crf}"
            )
    known = preset and preset.strip().lower()
    if known and known[0].isalpha():  # in a number, a sign or a point is not a separator
        known = _plain(known)
    if known is not None and known not in (codec.presets or ()):
        choices = f"one of {', '.join(codec.presets)}" if codec.presets else "left out"
        raise UsageError(f"{option('preset')} must be {choices} for {codec.name}, got {preset!r}")
    default_crf = codec.crf[2] if codec.crf else 0
    return codec.options(default_crf if crf is None else crf, known or codec.preset)
