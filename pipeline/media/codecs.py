"""Which video codecs and containers there are, and which of them suits a source."""

import os
from collections.abc import Callable
from dataclasses import dataclass

import av
from makeup_video.pipeline.errors import UsageError

CONTAINERS = {
    ".mp4": "mp4",
    ".m4v": "mp4",
    ".mov": "mov",
    ".mkv": "matroska",
    ".webm": "webm",
}
MATROSKA = ("matroska", "webm")  # one format, two names

# HEVC in mp4 and mov has two names. Apple's players take the one that puts the parameter sets into
# the header alone; FFmpeg writes the other, "hev1".
APPLE_HEVC = "hvc1"


@dataclass(frozen=True)
class VideoCodec:
    """One choice of --codec.

    pix_fmts: the layouts that we hand to FFmpeg's `encoder`.  crf: (lowest, highest, default)
    or None.  presets: what --preset takes, `preset` the default; None where there are none.
    tag: how mp4 and mov are to name it, None: as FFmpeg does.
    depth: bits a sample unless others are asked for; None: those of the source.
    interlaced: it can keep fields.  whole_chroma: it refuses odd sizes in 4:2:0.
    options: (crf, preset) -> the encoder's own options.
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
    options: Callable[[int, str], dict[str, str]]
    tag: str | None = None


_X26X_PRESETS = (
    "ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow", "slower", "veryslow",
)  # fmt: skip
_BASIC = ("yuv420p", "yuv422p", "yuv444p")
_FULL = ("yuvj420p", "yuvj422p", "yuvj444p")
_DEEP = ("yuv420p10le", "yuv422p10le", "yuv444p10le")
_DEEPER = ("yuv420p12le", "yuv422p12le", "yuv444p12le")

# Phones, browsers and television sets play H.264 of 8 bits alone, so that is its depth.
# The default crfs give the codecs about the same luma PSNR, that of H.264 at 18, which is visually
# lossless at normal size; each default preset keeps 720p30 in real time on two cores.
CODECS = {
    codec.name: codec
    for codec in (
        VideoCodec(
            "h264", "libx264", ("mp4", "mov", "matroska"), (*_BASIC, *_FULL, "nv12", *_DEEP),
            (0, 51, 18), _X26X_PRESETS, "veryfast", 8, True, True,
            lambda crf, preset: {"crf": str(crf), "preset": preset},
        ),
        VideoCodec(
            "hevc", "libx265", ("mp4", "mov", "matroska"), (*_BASIC, *_FULL, *_DEEP, *_DEEPER),
            (0, 51, 18), _X26X_PRESETS, "superfast", None, False, True,
            lambda crf, preset: {"crf": str(crf), "preset": preset}, APPLE_HEVC,
        ),
        VideoCodec(
            "av1", "libsvtav1", ("mp4", "matroska", "webm"), ("yuv420p", "yuv420p10le"),
            (1, 63, 26), tuple(str(n) for n in range(14)), "8", None, False, False,
            lambda crf, preset: {"crf": str(crf), "preset": preset},
        ),
        VideoCodec(
            "vp9", "libvpx-vp9", ("mp4", "matroska", "webm"), (*_BASIC, "yuva420p"),
            (0, 63, 24), tuple(str(n) for n in range(9)), "6", None, False, False,
            lambda crf, preset: {
                "crf": str(crf), "cpu-used": preset, "deadline": "realtime", "row-mt": "1",
                "tile-columns": "2", "auto-alt-ref": "0", "lag-in-frames": "0",
            },
        ),
        VideoCodec(
            "ffv1", "ffv1", ("matroska",),
            (*_BASIC, *_DEEP, *_DEEPER, "yuva420p", "yuva422p", "yuva444p", "yuva420p10le",
             "yuva422p10le", "yuva444p10le", "yuva422p12le", "yuva444p12le"),
            None, None, "", None, True, False,
            # FFmpeg chooses the slices: four, but where an odd size does not allow them
            lambda crf, preset: {"level": "3", "slicecrc": "1"},
        ),
        VideoCodec(
            "prores", "prores_ks", ("mov", "matroska"),
            ("yuv422p10le", "yuv444p10le", "yuva444p10le"),
            None, ("proxy", "lt", "standard", "hq", "4444", "4444xq"), "", None, True, False,
            lambda crf, preset: {"profile": preset} if preset else {},
        ),
    )
}  # fmt: skip


def container_of(path: str | os.PathLike[str]) -> str:
    """FFmpeg's muxer name for an output path. Raises UsageError for an extension we don't write."""
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    if suffix not in CONTAINERS:
        raise UsageError(
            f"output must end in {', '.join(CONTAINERS)} (or .jpg, .png, .webp for a picture), "
            f"got {os.fspath(path)}"
        )
    return CONTAINERS[suffix]


def pick_codec(name: str | None, container: str, *, deep: bool, alpha: bool) -> VideoCodec:
    """The codec asked for, or the container's best for this source.

    deep: more than 8 bits, or HDR.  Raises UsageError where codec and container do not go
    together.
    """
    if name is None:
        if alpha:
            name = {"mov": "prores", "matroska": "vp9", "webm": "vp9"}.get(container)
        name = name or (("av1" if deep else "vp9") if container == "webm" else None)
        name = name or ("hevc" if deep else "h264")
    if name not in CODECS:
        raise UsageError(f"--codec must be one of {', '.join(CODECS)}, got {name!r}")
    codec = CODECS[name]
    if container not in codec.containers:
        fitting = [c.name for c in CODECS.values() if container in c.containers]
        raise UsageError(f"{container} does not hold {name}; use --codec {' or '.join(fitting)}")
    return codec


def encoder_options(codec: VideoCodec, crf: int | None, preset: str | None) -> dict[str, str]:
    """The encoder's options for --crf and --preset; None means our default."""
    if crf is not None:
        if codec.crf is None:
            raise UsageError(f"{codec.name} has no --crf: leave it out")
        low, high, _ = codec.crf
        if not low <= crf <= high:
            raise UsageError(f"--crf must be in {low}..{high} for {codec.name}, got {crf}")
    if preset is not None and preset not in (codec.presets or ()):
        text = f"one of {', '.join(codec.presets)}" if codec.presets else "left out"
        raise UsageError(f"--preset must be {text} for {codec.name}, got {preset!r}")
    default_crf = codec.crf[2] if codec.crf else 0
    return codec.options(default_crf if crf is None else crf, preset or codec.preset)


def bits_of(pix_fmt: str) -> int:
    """Bits a sample of one of FFmpeg's layouts."""
    return av.VideoFormat(pix_fmt).components[0].bits
