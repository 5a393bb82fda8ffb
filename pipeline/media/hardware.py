"""Encoders on graphics chips: which kinds there are, and which of them work on this machine.

FFmpeg lists every encoder that it was built with, whether or not the chip and its driver are there.
So each encoder is tried with one frame. The module is imported for the command's help text, so it
loads no large library.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from makeup_video.pipeline.errors import EncodeError, UsageError, option, reason_of
from makeup_video.pipeline.media.codecs import CODECS, VideoCodec, encoder_options

NONE, AUTO = "none", "auto"
_CRF_RANGE = (0, 51)  # these encoders share the quality scale of the codecs with this range
_TRIED_WH = (1280, 720)
_LAMBDA = 118  # FFmpeg's FF_QP2LAMBDA: its generic quality counts in these units
_EIGHT_BITS, _TEN_BITS = ("yuv420p", "nv12"), ("yuv420p10le", "p010le")


class Hardware(NamedTuple):
    """The encoders of one interface to graphics chips. FFmpeg calls them CODEC_NAME.

    name: the one that users choose.  presets, preset, options: as in VideoCodec.
    device: FFmpeg's type of the device that pictures are sent to; None: the encoder itself sends
    them.
    """

    name: str
    presets: tuple[str, ...] | None
    preset: str
    options: Callable[[int, str], dict[str, str]]
    device: str | None = None


# In the order in which `auto` tries them. The options ask for a constant quality near that of the
# software encoder at the same crf. For some encoders a quality of 0 means "choose one", so the best
# is 1.
HARDWARE = {
    hardware.name: hardware
    for hardware in (
        Hardware(
            "videotoolbox", None, "",
            lambda crf, preset: {
                "flags": "+qscale", "global_quality": str(_LAMBDA * round(100 * (1 - crf / 51)))
            },
        ),
        Hardware(
            "nvenc", tuple(f"p{number}" for number in range(1, 8)), "p4",
            lambda crf, preset: {
                "preset": preset, "rc": "vbr", "cq": str(max(1, crf)), "b": "0"
            },
        ),
        Hardware(
            "qsv", ("veryfast", "faster", "fast", "medium", "slow", "slower", "veryslow"), "medium",
            lambda crf, preset: {"preset": preset, "global_quality": str(max(1, crf))},
        ),
        Hardware(
            "vaapi", None, "",
            lambda crf, preset: {"rc_mode": "CQP", "qp": str(max(1, crf))},
            device="vaapi",
        ),
    )
}  # fmt: skip


class EncoderNeeds(NamedTuple):
    """What a video needs of an encoder.

    size_wh, pix_fmt: of the pictures.  crf, preset: the user's choice; None: the default.
    depth: bits per sample; None: as usual for the codec.  interlaced: the video has fields.
    """

    size_wh: tuple[int, int]
    pix_fmt: str
    crf: int | None = None
    preset: str | None = None
    depth: int | None = None
    interlaced: bool = False


def check_hardware(name: str) -> None:
    """Raises UsageError unless the name is one of HARDWARE, "auto" or "none"."""
    if name not in (NONE, AUTO, *HARDWARE):
        raise UsageError(
            f"{option('hardware')} must be one of {AUTO}, {NONE}, {', '.join(HARDWARE)}, "
            f"got {name!r}"
        )


def pick_encoder(codec: VideoCodec, name: str, wanted: EncoderNeeds) -> tuple[VideoCodec, str]:
    """The codec with the encoder to use, and a line about the choice; "" when name is "none".

    name: "none"; or "auto" for the first encoder that works, else the codec's own; or one of
    HARDWARE.  Raises UsageError or EncodeError when a named encoder cannot encode the video.
    """
    if name == NONE:
        return codec, ""
    reasons = []
    for hardware in HARDWARE.values() if name == AUTO else [HARDWARE[name]]:
        row = on_hardware(codec, hardware)
        if row is None:
            if name != AUTO:  # with auto, an encoder that FFmpeg lacks is not worth a line
                reasons.append(
                    f"{hardware.name}: this FFmpeg has no {_encoder_of(codec, hardware)}"
                )
            continue
        reason = _why_not(row, wanted, is_named=name != AUTO)
        if not reason:
            return row, row.encoder
        reasons.append(f"{hardware.name}: {reason}")
    why = "; ".join(reasons) or f"this FFmpeg has none for {codec.name}"
    if name != AUTO:
        raise EncodeError(
            f"{option('hardware')}: {why}. Choose {AUTO} for what works here, or leave it out for "
            f"{codec.encoder}"
        )
    return codec, f"{codec.encoder}, since no hardware encoder works here ({why})"


def on_hardware(codec: VideoCodec, hardware: Hardware) -> VideoCodec | None:
    """The codec's row with the encoder of a chip; None where this FFmpeg has no such encoder."""
    import av

    encoder = _encoder_of(codec, hardware)
    if codec.crf is None or codec.crf[:2] != _CRF_RANGE or encoder not in av.codecs_available:
        return None
    handed = (_EIGHT_BITS,) if codec.depth == 8 else (_EIGHT_BITS, _TEN_BITS)
    return codec._replace(
        encoder=encoder,
        pix_fmts=tuple(ours for ours, _ in handed),
        handed=handed,
        presets=hardware.presets,
        preset=hardware.preset,
        options=hardware.options,
        device=hardware.device,
        interlaced=False,
        hdr=None,
        stereo=False,
        parameters="",
        quiet=(),
        bottom_first=(),
        many_threads=False,
        is_hardware=True,
    )


def _encoder_of(codec: VideoCodec, hardware: Hardware) -> str:
    return f"{codec.name}_{hardware.name}"


def hardware_found() -> Iterator[tuple[str, str]]:
    """Pairs of a name in HARDWARE and its encoders that work on this machine."""
    for hardware in HARDWARE.values():
        rows = [on_hardware(codec, hardware) for codec in CODECS.values()]
        wanted = EncoderNeeds(_TRIED_WH, _EIGHT_BITS[0])
        working = [row.encoder for row in rows if row and not _why_not(row, wanted, is_named=False)]
        if working:
            yield hardware.name, ", ".join(working)


def _why_not(row: VideoCodec, wanted: EncoderNeeds, *, is_named: bool) -> str:
    """Why this encoder cannot encode the video; "" when it can.

    is_named: the user named this encoder, so a preset or depth that it lacks raises UsageError.
    """
    from makeup_video.pipeline.media.pixel_format import pick_pix_fmt

    if wanted.interlaced:
        return "it cannot keep the fields of an interlaced video"
    lacking = f"it has no preset {wanted.preset}"
    try:
        options = encoder_options(row, wanted.crf, wanted.preset)
        lacking = f"it has no {wanted.depth} bits"
        pix_fmt = pick_pix_fmt(wanted.pix_fmt, row, wanted.depth)
    except UsageError:
        if is_named:
            raise
        return lacking
    return _try(row, wanted.size_wh, pix_fmt, options)


def _try(row: VideoCodec, size_wh: tuple[int, int], pix_fmt: str, options: dict[str, str]) -> str:
    """Encode one grey frame; returns why that failed, "" when it did not."""
    import av

    try:
        with av.open("null", "w", format="null") as out:
            stream = add_stream(out, row, 30)
            context = stream.codec_context
            context.width, context.height = (length + length % 2 for length in size_wh)
            context.pix_fmt = handed_format(row, pix_fmt)
            stream.options.update(options)
            frame = av.VideoFrame(context.width, context.height, pix_fmt)
            for plane in frame.planes:
                plane.update(bytes([128]) * plane.buffer_size)
            frame.pts = 0
            packets = [*stream.encode(frame), *stream.encode(None)]
    except (av.FFmpegError, ValueError, RuntimeError) as error:
        return reason_of(error)
    return "" if any(packet.size for packet in packets) else "it encodes nothing"


def add_stream(container: Any, row: VideoCodec, rate: Any) -> Any:
    """Add the output's video stream, with the device that the encoder needs."""
    if row.device is None:
        return container.add_stream(row.encoder, rate=rate)
    from av.codec.hwaccel import HWAccel

    return container.add_stream(row.encoder, rate=rate, hwaccel=HWAccel(row.device))


def handed_format(row: VideoCodec, pix_fmt: str) -> str:
    """The pixel format in which pictures are handed to the encoder."""
    return dict(row.handed).get(pix_fmt, pix_fmt)
