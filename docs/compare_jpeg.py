"""Measures ways to make the live page's JPEG from a frame's planes; the table is in decisions.md.

    python docs/compare_jpeg.py [CLIP.mp4]

CPU ms a frame on one thread: medians of rounds in which all take turns; sizes in kB, so that nobody wins by a lower quality.
"""

import sys
import time
from collections.abc import Callable
from fractions import Fraction
from itertools import count
from pathlib import Path
from statistics import median
from typing import Any

import av
import cv2
import numpy as np
import simplejpeg
from makeup_video.pipeline import ColourTags, Frame
from makeup_video.pipeline.images.jpeg import PreviewJpeg

SAMPLE = Path(__file__).resolve().parent.parent / "samples" / "in.mp4"
SIZES = ((1280, 720), (1920, 1080), (3840, 2160))
QUALITY, ROUNDS = 85, 25
FFMPEG_QUALITY = 3  # qscale whose files are as large as libjpeg's at 85


def main() -> None:
    cv2.setNumThreads(1)
    clip = Path(sys.argv[1]) if len(sys.argv) > 1 else SAMPLE
    with av.open(str(clip)) as box:
        picture = next(box.decode(video=0))
    for width, height in SIZES:
        ways = ways_of(picture, width, height)
        sizes = {name: len(way()) / 1000 for name, way in ways.items()}
        for name, ms in measured(ways).items():
            print(f"{width}x{height}  {name:44} {ms:6.2f} ms {sizes[name]:6.0f} kB")


def ways_of(picture: av.VideoFrame, width: int, height: int) -> dict[str, Callable[[], bytes]]:
    """Each makes the same picture's JPEG; those that convert get BT.709, limited range."""

    def like(
        pix_fmt: str, matrix: int, range_: int
    ) -> tuple[tuple[np.ndarray, ...], Any, ColourTags]:
        shown = picture.reformat(width, height, format=pix_fmt)
        tags = ColourTags(matrix, range_)
        frame = Frame(shown, 0, Fraction(1, 30), tags)
        return frame.planes, (frame.chroma, frame.bit_depth), tags

    def ours(limit_px: int = 4096, **how: Any) -> Callable[[], bytes]:
        planes, about, tags = like(**how)
        jpeg = PreviewJpeg(QUALITY, limit_px)
        return lambda: jpeg(planes, *about, tags)

    video = {"pix_fmt": "yuv420p", "matrix": 1, "range_": 1}
    planes, _, _ = like(**video)
    shown = picture.reformat(width, height, format="yuv420p")
    i420 = np.concatenate([plane.ravel() for plane in planes]).reshape(-1, width)

    def by_opencv() -> bytes:
        rgb = cv2.cvtColor(i420, cv2.COLOR_YUV2BGR_I420)  # BT.601, whatever the tags say
        return cv2.imencode(".jpg", rgb, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()

    def by_swscale() -> bytes:
        full = shown.reformat(
            format="yuvj420p",
            src_colorspace=1,
            dst_colorspace=5,
            src_color_range=1,
            dst_color_range=2,
        )
        parts = Frame(full, 0, Fraction(1, 30), ColourTags()).planes
        return bytes(simplejpeg.encode_jpeg_yuv_planes(*parts, quality=QUALITY))

    return {
        "ours: 4:2:0, BT.709, limited": ours(**video),
        "ours, halved": ours(limit_px=width - 1, **video),
        "ours: NV12, BT.709, limited": ours(**{**video, "pix_fmt": "nv12"}),
        "ours: 4:2:2, BT.601, limited (YUYV camera)": ours(pix_fmt="yuv422p", matrix=5, range_=1),
        "ours: 4:2:2, as MJPEG cameras give it": ours(pix_fmt="yuvj422p", matrix=5, range_=2),
        "ours: 4:2:0, 10 bits, PQ": ours_hdr(picture, width, height),
        "libjpeg-turbo alone, 4:2:0": lambda: bytes(
            simplejpeg.encode_jpeg_yuv_planes(*planes, quality=QUALITY)
        ),
        "swscale, then libjpeg-turbo": by_swscale,
        "OpenCV: to BGR as if BT.601, imencode": by_opencv,
        "FFmpeg's mjpeg alone, huffman=default": by_ffmpeg(shown, "default"),
        "FFmpeg's mjpeg alone, huffman=optimal": by_ffmpeg(shown, "optimal"),
    }


def ours_hdr(picture: av.VideoFrame, width: int, height: int) -> Callable[[], bytes]:
    shown = picture.reformat(width, height, format="yuv420p10le")
    tags = ColourTags(9, 1, 16, 9)
    frame, jpeg = Frame(shown, 0, Fraction(1, 30), tags), PreviewJpeg(QUALITY, 4096)
    return lambda: jpeg(frame.planes, frame.chroma, 10, tags)


def by_ffmpeg(shown: av.VideoFrame, huffman: str) -> Callable[[], bytes]:
    context: Any = av.CodecContext.create("mjpeg", "w")
    context.width, context.height, context.pix_fmt = shown.width, shown.height, "yuvj420p"
    context.time_base, context.thread_count = Fraction(1, 30), 1
    context.options = {"huffman": huffman, "flags": "+qscale"}
    context.global_quality = FFMPEG_QUALITY * 118  # FF_QP2LAMBDA
    number = count()

    def way() -> bytes:
        shown.pts, shown.time_base = next(number), Fraction(1, 30)
        return b"".join(bytes(packet) for packet in context.encode(shown))

    return way


def measured(ways: dict[str, Callable[[], bytes]]) -> dict[str, float]:
    taken: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(ROUNDS):
        for name, way in ways.items():
            began = time.thread_time()
            way()
            taken[name].append(1000 * (time.thread_time() - began))
    return {name: median(times) for name, times in taken.items()}


if __name__ == "__main__":
    main()
