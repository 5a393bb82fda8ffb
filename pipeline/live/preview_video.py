"""Encodes the planes of frames as H.264 for the page in a browser on another machine.

The browser decodes the stream with WebCodecs.
"""

from fractions import Fraction
from typing import Any

import av
import cv2
import numpy as np
from av.video.frame import PictureType
from makeup_video.pipeline.errors import EncodeError
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import plane_views
from makeup_video.pipeline.images.preview_planes import LIMIT_PX, VIDEO, Planes, preview_planes
from makeup_video.pipeline.media.codecs import PLAYS_EVERYWHERE

_ENCODER = PLAYS_EVERYWHERE.encoder
_LIMITED = 1  # limited range, as FFmpeg numbers it
_NEUTRAL = 128  # Cb and Cr of grey
# ultrafast: superfast takes twice the CPU time for a tenth less data. Chroma is quantised more
# finely than x264 does by default, to be as exact as in our JPEGs: the page exists to show the
# colour of lips. Key frames come only on request.
_OPTIONS = {
    "preset": "ultrafast",
    "tune": "zerolatency",
    "crf": "20",
    "forced-idr": "1",
    "x264-params": "chroma-qp-offset=-4:keyint=infinite:scenecut=0:sliced-threads=0",
}
_RATE = 30  # frames per second, for rate control alone


class PreviewVideo:
    """Encodes planes, as in Frame.planes, to one packet for each picture.

    A packet is in the byte stream format of H.264 (Annex B), and each key frame carries the
    headers. The first picture is a key frame, as is every picture whose size differs from the last.
    limit_px: a picture is halved until no side is longer.
    """

    def __init__(self, limit_px: int = LIMIT_PX) -> None:
        self._limit_px = limit_px
        self._context: Any = None
        self._size_wh = 0, 0
        self._count = 0

    @staticmethod
    def is_available() -> bool:
        """Whether this PyAV has the encoder."""
        return _ENCODER in av.codecs_available

    def __call__(
        self,
        planes: Planes,
        chroma: tuple[int, int],
        bit_depth: int,
        tags: ColourTags,
        key: bool = False,
    ) -> tuple[bytes, bool]:
        """Encode a picture. Returns the packet, and whether it is a key frame.

        chroma, bit_depth, tags: the frame's.  key: make the picture a key frame.
        A picture with a side of odd length loses a row or a column. Raises EncodeError, and
        UsageError as `preview_planes` does.
        """
        luma, *rest = preview_planes(planes, chroma, bit_depth, tags, VIDEO, self._limit_px)
        height, width = (max(2, side // 2 * 2) for side in luma.shape)
        if (width, height) != self._size_wh:
            self._open(width, height)
            key = True
        picture = av.VideoFrame(width, height, "yuv420p")
        views = plane_views(picture, 8)
        views[0][:] = luma[:height, :width]
        for number, view in enumerate(views[1:]):
            view[:] = _half(rest[number], chroma, view.shape) if rest else _NEUTRAL
        picture.pts = self._count
        self._count += 1
        if key:
            picture.pict_type = PictureType.I
        return self._encoded(picture)

    def _open(self, width: int, height: int) -> None:
        context: Any = av.CodecContext.create(_ENCODER, "w")
        context.width, context.height, context.pix_fmt = width, height, "yuv420p"
        context.time_base, context.framerate = Fraction(1, _RATE), Fraction(_RATE)
        context.thread_count = 1  # slices would add data, and the live run uses the other cores
        context.colorspace, context.color_range = VIDEO.matrix, _LIMITED
        context.color_trc, context.color_primaries = VIDEO.transfer, VIDEO.primaries
        context.options = _OPTIONS
        try:
            context.open()
        except (av.FFmpegError, ValueError) as error:
            raise EncodeError(
                f"{_ENCODER} refuses pictures of {width}x{height} for the page: the page gets JPEG"
            ) from error
        self._context, self._size_wh = context, (width, height)

    def _encoded(self, picture: av.VideoFrame) -> tuple[bytes, bool]:
        try:
            (packet,) = self._context.encode(picture)
        except (av.FFmpegError, ValueError) as error:  # no packet, or several
            raise EncodeError(f"{_ENCODER} failed: the page gets JPEG") from error
        return bytes(packet), packet.is_keyframe


def _half(plane: np.ndarray, chroma: tuple[int, int], shape: tuple[int, ...]) -> np.ndarray:
    """A chroma plane at half the size of luma: uint8 of the given shape, (H, W)."""
    if chroma != (2, 2):
        return np.asarray(cv2.resize(plane, shape[::-1], interpolation=cv2.INTER_AREA))
    return plane[: shape[0], : shape[1]]
