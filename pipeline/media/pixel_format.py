"""Converts decoded pictures to the one pixel format that the encoder takes.

Nothing else in a run changes the pixel format.
"""

import re
from typing import TYPE_CHECKING

import av
import numpy as np
from av.codec.codec import find_best_pix_fmt_of_list
from av.video.reformatter import ColorRange, Colorspace
from makeup_video.kernels.colour import HDR_TRANSFERS
from makeup_video.pipeline.errors import DecodeError, UsageError, option
from makeup_video.pipeline.frames.colour_tags import is_full_range
from makeup_video.pipeline.frames.frame import layout_of, plane_views
from makeup_video.pipeline.frames.transform import ffmpeg_range
from makeup_video.pipeline.media.codecs import CODECS, CONTAINERS, VideoCodec

if TYPE_CHECKING:
    from makeup_video.pipeline.media.to_sdr import ToSdr

# Pixel formats whose 16-bit words have room for more than the bits of a sample.
_ROOMY = re.compile(r"(yuva?\d{3}p|gbra?p|gray)(9|10|12|14)le")
# Grey, or grey with transparency ("ya"): integers or floats; 8 bits where the name has no number.
_GREY = re.compile(r"(gray|ya)f?(\d*)(?:[lb]e)?")


def bits_of(pix_fmt: str) -> int:
    """Bits per sample of one of FFmpeg's pixel formats."""
    return layout_of(pix_fmt).bit_depth


def pick_pix_fmt(source: str, codec: VideoCodec, depth: int | None = None) -> str:
    """Of the pixel formats that the codec takes, the one that loses least of the source.

    source: the source's pixel format.  depth: bits per sample; None: as usual for the codec.
    Raises UsageError for a depth that the codec does not have.
    """
    wanted = depth or codec.depth
    fitting = [name for name in codec.pix_fmts if wanted in (None, bits_of(name))]
    if not fitting:
        depths = sorted({bits_of(name) for name in codec.pix_fmts})
        raise UsageError(
            f"{option('bit_depth')} must be {' or '.join(map(str, depths))} for {codec.name}, got "
            f"{depth}"
        )
    if source in fitting:
        return source
    if (grey := _GREY.fullmatch(source)) is not None:
        source = _in_420(*grey.groups())  # FFmpeg would choose full-range 4:4:4
    if _is_rgb(source) and codec.depth is not None and codec.depth == wanted:
        source = "yuv420p"  # few players take 4:4:4
    has_alpha = any(c.is_alpha for c in av.VideoFormat(source).components)
    best, _loss = find_best_pix_fmt_of_list(fitting, source, has_alpha)
    assert best is not None
    return best.name


def _in_420(kind: str, bits: str) -> str:
    """The 4:2:0 format that holds all of a grey one; 4:2:0 formats have at most 16 bits."""
    plain = "yuva420p" if kind == "ya" else "yuv420p"
    return plain if bits in ("", "8") else f"{plain}{min(int(bits), 16)}le"


class ConvertPixelFormat:
    """Converts every picture to the one pixel format that the encoder takes.

    A picture that already fits is returned as it is, without a copy.
    depth: bits per sample; None: as usual for the codec.  sdr: PQ and HLG become SDR.
    is_opaque: pictures are RGB with transparency, but opaque everywhere.
    conversions: what changes.  unasked: those conversions that neither depth nor sdr asked for.
    dropped: what the conversion loses.
    mended: how many damaged pictures had samples beyond their depth. They are clipped, since
    neither x264 nor the kernels can take them.
    """

    def __init__(
        self,
        codec: VideoCodec,
        depth: int | None = None,
        *,
        sdr: bool = False,
        is_opaque: bool = False,
    ) -> None:
        self.codec, self.depth, self.sdr, self._is_opaque = codec, depth, sdr, is_opaque
        self.conversions: list[str] = []
        self.unasked: list[str] = []
        self.dropped: list[str] = []
        self.mended = 0
        self._pix_fmt = ""
        self._seen: tuple[int, int, str] | None = None
        self._to_sdr: ToSdr | None = None
        self._to_limited = False  # full range becomes limited

    def __call__(self, picture: av.VideoFrame, seconds: float | None = None) -> av.VideoFrame:
        """Raises DecodeError when size or pixel format differ from the first picture's, UsageError
        for a depth that the codec does not have.

        seconds: where the picture is in its file, for the error message; None: not known.
        """
        name = picture.format.name  # read once: PyAV makes new objects for each access
        self.mended += _clip_to_depth(picture, name)  # before anything converts it
        key = (picture.width, picture.height, name)
        if self._seen is None:
            self._begin(picture)
            self._seen = key
        elif key != self._seen:
            place = "" if seconds is None else f" at {seconds:.2f} s"
            raise DecodeError(
                f"the picture changes from {_text(self._seen)} to {_text(key)}{place}: one output "
                "holds one size; cut the file there and run the parts"
            )
        picture = self._converted(picture, name)
        padded_wh = self._padded_wh(picture)
        return picture if padded_wh == key[:2] else _pad(picture, padded_wh)

    def _begin(self, picture: av.VideoFrame) -> None:
        name = "rgb24" if self._is_opaque else picture.format.name
        self._pix_fmt = pick_pix_fmt(name, self.codec, self.depth)
        if self.sdr and picture.color_trc in HDR_TRANSFERS:
            from makeup_video.pipeline.media.to_sdr import ToSdr

            self._to_sdr = ToSdr(picture, self._pix_fmt)
        self._to_limited = _is_full(picture) and not self.codec.full_range
        self._note(picture)

    def _converted(self, picture: av.VideoFrame, name: str) -> av.VideoFrame:
        """name: the picture's pixel format."""
        if self._to_sdr is not None:
            return self._to_sdr(picture)
        if name != self._pix_fmt or self._to_limited:
            return _reformat(picture, self._pix_fmt, to_limited=self._to_limited)
        return picture

    def _padded_wh(self, picture: av.VideoFrame) -> tuple[int, int]:
        """The size that the encoder accepts, which may need whole chroma samples."""
        if not self.codec.whole_chroma:
            return picture.width, picture.height
        across, down = layout_of(self._pix_fmt).chroma
        down *= 2 if picture.interlaced_frame else 1
        return -(-picture.width // across) * across, -(-picture.height // down) * down

    def _note(self, picture: av.VideoFrame) -> None:
        name = picture.format.name
        has_alpha = _has_alpha(picture.format) and not self._is_opaque
        if has_alpha and not _has_alpha(av.VideoFormat(self._pix_fmt)):
            self.dropped.append(
                f"transparency: {self.codec.name} has none here; {_transparent_codecs()} keep it"
            )
        # yuvj420p is yuv420p with its full range in the name; the range tag says the same
        if name.replace("yuvj", "yuv") != self._pix_fmt.replace("yuvj", "yuv"):
            self.conversions.append(f"pixels {name} -> {self._pix_fmt}{self._why(picture)}")
            if self.depth is None:
                self.unasked.append(self.conversions[-1])
        if self._to_limited and self._to_sdr is None:
            self.conversions.append(
                f"range full -> limited ({self.codec.name} cannot say that it is full)"
            )
            self.unasked.append(self.conversions[-1])
        if self._to_sdr is not None:
            self.conversions.append(
                f"HDR ({HDR_TRANSFERS[int(picture.color_trc)]}, up to "
                f"{self._to_sdr.peak_nits:.0f} cd/m2) -> SDR by the tone curve of ITU-R "
                "BT.2390"
            )
        size, padded = (picture.width, picture.height), self._padded_wh(picture)
        if padded != size:
            self.conversions.append(
                f"size {size[0]}x{size[1]} -> {padded[0]}x{padded[1]} (edge repeated)"
            )
            self.unasked.append(self.conversions[-1])

    def _why(self, picture: av.VideoFrame) -> str:
        """The reason for less chroma or fewer bits that nobody asked for, and a warning about HDR
        in too few bits."""
        if self._to_sdr is not None:
            return ""
        before, after = bits_of(picture.format.name), bits_of(self._pix_fmt)
        deepest = max(bits_of(name) for name in self.codec.pix_fmts)
        is_usual, reasons = self.codec.depth == after, []
        if is_usual and _is_rgb(picture.format.name):
            reasons.append(f"few players can show 4:4:4 in {self.codec.name}")
        if is_usual and after < before and self.depth is None:
            reasons.append(
                f"few players can show more than {after} bits in {self.codec.name}; a bit depth of "
                f"{deepest} keeps {'them' if deepest >= before else 'more'}"
            )
        if after < before and picture.color_trc in HDR_TRANSFERS:
            reasons.append(f"HDR in {after} bits shows bands; SDR does not")
        return f" ({'; '.join(reasons)})" if reasons else ""


def _transparent_codecs() -> str:
    """The codecs that keep transparency, and where: "vp9 in .webm and .mkv, ..."."""
    endings = {container: end for end, container in CONTAINERS.items() if end != ".m4v"}
    places = [
        f"{codec.name} in {' and '.join(endings[container] for container in codec.transparent_in)}"
        for codec in CODECS.values()
        if codec.transparent_in
    ]
    return f"{', '.join(places[:-1])} and {places[-1]}"


def _clip_to_depth(picture: av.VideoFrame, name: str) -> bool:
    """Clip samples beyond the picture's depth, which damaged streams have; True if any.

    name: the picture's pixel format.
    """
    if not _ROOMY.fullmatch(name):
        return False
    largest = 2 ** bits_of(name) - 1
    if all(plane.max() <= largest for plane in plane_views(picture, 16)):
        return False
    picture.make_writable()  # the decoder may still predict from this memory
    for plane in plane_views(picture, 16):
        np.minimum(plane, largest, out=plane)
    return True


def _has_alpha(fmt: av.VideoFormat) -> bool:
    return any(component.is_alpha for component in fmt.components)


def _is_rgb(pix_fmt: str) -> bool:
    fmt = av.VideoFormat(pix_fmt)
    return fmt.is_rgb or fmt.has_palette


def _is_full(picture: av.VideoFrame) -> bool:
    """True for a picture of Y'CbCr whose samples have the full range."""
    name = picture.format.name
    return is_full_range(picture.color_range, name) and not _is_rgb(name)


def _text(key: tuple[int, int, str]) -> str:
    return f"{key[0]}x{key[1]} {key[2]}"


def _reformat(picture: av.VideoFrame, pix_fmt: str, *, to_limited: bool) -> av.VideoFrame:
    """Change the pixel format and keep the colour coding: same matrix, and same range unless
    to_limited.

    On one thread: with several, FFmpeg's converter writes random pixels where its slices meet, when
    a sample of the new format has more than 8 bits and the width is not a multiple of 16.
    """
    if _is_rgb(picture.format.name):
        # RGB has no matrix of its own. Every player assumes limited-range BT.709 for HD.
        out = picture.reformat(
            format=pix_fmt, dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG,
            threads=1,
        )  # fmt: skip
        out.colorspace, out.color_range = Colorspace.ITU709, ColorRange.MPEG
        return out
    is_full = _is_full(picture)
    out = picture.reformat(
        format=pix_fmt, src_color_range=ffmpeg_range(is_full),
        dst_color_range=ffmpeg_range(is_full and not to_limited), threads=1,
    )  # fmt: skip
    out.colorspace, out.color_trc = picture.colorspace, picture.color_trc
    out.color_primaries = picture.color_primaries
    if to_limited:
        out.color_range = ColorRange.MPEG
    else:
        out.color_range = ColorRange.JPEG if is_full else picture.color_range
    return out


def _pad(picture: av.VideoFrame, size_wh: tuple[int, int]) -> av.VideoFrame:
    """A copy with the last column and row repeated up to size_wh."""
    # Only reformat makes a larger picture that keeps field order and side data. All of its pixels
    # are overwritten.
    out = picture.reformat(width=size_wh[0], height=size_wh[1])
    depth = picture.format.components[0].bits
    for old, new in zip(plane_views(picture, depth), plane_views(out, depth), strict=True):
        rows = np.minimum(np.arange(new.shape[0]), old.shape[0] - 1)
        columns = np.minimum(np.arange(new.shape[1]), old.shape[1] - 1)
        new[:] = old[rows[:, None], columns]
    return out
