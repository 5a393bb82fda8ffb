"""A decoded video frame: its planes, time and colour tags."""

from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

import av
import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.pipeline.frames.colour_tags import FULL_RANGE, ColourTags, is_full_range, resolve

_INTERLEAVED = ("nv12", "nv16")  # a plane of luma, and one in which Cb and Cr alternate


class Layout(NamedTuple):
    """What FFmpeg's name of a pixel format means.

    It is looked up once per format: every attribute of a PyAV format costs a new object, and
    several stages need one for every frame.

    chroma: px of a picture per chroma sample, across and down.
    in_planes: luma, Cb and Cr lie in planes that numpy reads as they are: of bytes, or of
    little-endian words whose high bits are empty.
    """

    bit_depth: int
    chroma: tuple[int, int]
    in_planes: bool


@lru_cache
def layout_of(pix_fmt: str) -> Layout:
    """The layout of one of FFmpeg's pixel formats."""
    fmt = av.VideoFormat(pix_fmt)
    # 64 is a multiple of every factor there is, so the quotient is the factor itself
    chroma = 64 // fmt.chroma_width(64), 64 // fmt.chroma_height(64)
    if not fmt.components:
        raise ValueError(f"{pix_fmt} has no planes in memory: give frames as yuv420p or nv12")
    depth, planes = fmt.components[0].bits, [component.plane for component in fmt.components]
    in_planes = (
        8 <= depth <= 16
        and "f" not in pix_fmt  # grayf32le has floats
        and not (fmt.is_rgb or fmt.is_big_endian or fmt.has_palette)
        and (planes == list(range(len(planes))) or pix_fmt in _INTERLEAVED)
        and "msb" not in pix_fmt  # yuv444p10msble has its samples in the high bits
    )
    return Layout(depth, chroma, in_planes)


@dataclass(slots=True)
class Frame:
    """One decoded picture as Y'CbCr planes, with its time and colour tags.

    picture: the FFmpeg frame that owns the memory; the planes are views of it.
    pix_fmt: FFmpeg's name of the pixel format, such as yuv420p or yuv420p10le.
    pts: presentation time in ticks of `time_base` (seconds per tick); the origin is the source's.
    rotation_degrees: counter-clockwise turn (0, 90, 180 or 270) that makes the picture upright. The
    stored picture itself is never turned.
    is_mirrored: the viewer sees that upright picture with left and right exchanged.
    tags: if they give no range, it is full where the pixel format's name says so ("yuvj420p").
    """

    picture: av.VideoFrame
    pts: int
    time_base: Fraction
    tags: ColourTags
    rotation_degrees: int = 0
    is_mirrored: bool = False
    pix_fmt: str = field(init=False)
    width_px: int = field(init=False)
    height_px: int = field(init=False)
    _planes: tuple[np.ndarray, ...] | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.picture, av.VideoFrame):
            got = type(self.picture).__name__
            raise TypeError(
                f"picture must be an av.VideoFrame, got {got}: av.VideoFrame.from_ndarray makes one"
            )
        if not isinstance(self.time_base, Fraction):
            raise TypeError(
                f"time_base must be a Fraction of seconds, got {self.time_base!r}: give "
                "Fraction(1, 30) for 30 ticks a second"
            )
        if not isinstance(self.tags, ColourTags):
            raise TypeError(
                f"tags must be ColourTags, got {type(self.tags).__name__}: give ColourTags() for a "
                "picture without tags"
            )
        self.width_px, self.height_px = self.picture.width, self.picture.height
        self.pix_fmt = self.picture.format.name
        if not self.tags.range and is_full_range(0, self.pix_fmt):
            self.tags = replace(self.tags, range=FULL_RANGE)
        if self.width_px < 1 or self.height_px < 1:
            raise ValueError(
                f"a frame has at least 1x1 pixels, got {self.width_px}x{self.height_px}"
                f" at pts {self.pts}"
            )
        if not layout_of(self.pix_fmt).in_planes:
            raise ValueError(
                f"a frame must have planes of luma, Cb and Cr, such as yuv420p or nv12, got "
                f"{self.pix_fmt}"
            )
        if self.rotation_degrees not in (0, 90, 180, 270):
            raise ValueError(
                f"rotation must be 0, 90, 180 or 270 degrees, got {self.rotation_degrees}"
            )

    @property
    def seconds(self) -> float:
        """The presentation time: float(pts * time_base), without the cost of a Fraction."""
        return self.pts * self.time_base.numerator / self.time_base.denominator

    @property
    def bit_depth(self) -> int:
        return layout_of(self.pix_fmt).bit_depth

    @property
    def chroma(self) -> tuple[int, int]:
        """(horizontal, vertical) subsampling factors: (2, 2) for 4:2:0, (1, 1) for 4:4:4."""
        return layout_of(self.pix_fmt).chroma

    @property
    def planes(self) -> tuple[np.ndarray, ...]:
        """Read-only views, luma first: (H, W) uint8 or uint16; NV12's chroma is (H/2, W/2, 2)."""
        if self._planes is None:
            self._planes = plane_views(self.picture, self.bit_depth)
            for plane in self._planes:
                plane.flags.writeable = False
        return self._planes

    def writable_planes(self) -> tuple[np.ndarray, ...]:
        """The planes for painting. Call this only when something will be painted.

        The decoder may still predict later frames from this memory. If so, FFmpeg copies it here
        (0.2 ms at 1080p); otherwise painting would change those frames.
        """
        self.picture.make_writable()
        self._planes = None
        return plane_views(self.picture, self.bit_depth)

    def __repr__(self) -> str:
        return (
            f"Frame({self.pix_fmt} {self.width_px}x{self.height_px}, pts={self.pts}, "
            f"time_base={self.time_base}, {self.tags}, rotation_degrees={self.rotation_degrees})"
        )


def coding_of(frame: Frame) -> Coding:
    """The coding of a frame. Raises UsageError as `resolve` does."""
    return resolve(frame.tags, frame.width_px, frame.height_px, frame.bit_depth)


def plane_views(picture: av.VideoFrame, bit_depth: int) -> tuple[np.ndarray, ...]:
    """Writable views of a picture's planes, without the padding of their lines.

    See Frame.planes.
    """
    dtype = np.dtype(np.uint8 if bit_depth <= 8 else np.uint16)
    interleaved = picture.format.name in _INTERLEAVED
    views = []
    for index, plane in enumerate(picture.planes):
        hw, line, size = (plane.height, plane.width), plane.line_size, dtype.itemsize
        if interleaved and index == 1:
            views.append(np.ndarray((*hw, 2), dtype, memoryview(plane), 0, (line, 2 * size, size)))
        else:
            views.append(np.ndarray(hw, dtype, memoryview(plane), 0, (line, size)))
    return tuple(views)
