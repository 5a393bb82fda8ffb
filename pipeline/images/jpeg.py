"""Encodes the planes of a frame as a JPEG whose colours a browser shows as they were painted.

A JPEG file (JFIF) is full-range BT.601, which browsers take for sRGB. Planes of a camera's MJPEG
already have this coding and go to the encoder unchanged.
"""

import cv2
import simplejpeg
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.images.hdr_preview import JFIF
from makeup_video.pipeline.images.preview_planes import LIMIT_PX, Planes, preview_planes

QUALITY = 85
_KNOWN_CHROMA = {(1, 1), (2, 1), (2, 2), (1, 2), (4, 1)}  # subsampling that the encoder accepts


class PreviewJpeg:
    """Encodes planes, as Frame.planes has them, to the bytes of a JPEG file.

    The given planes stay unchanged.
    quality: libjpeg's, 1..100.  limit_px: a picture is halved until no side exceeds this.
    """

    def __init__(self, quality: int = QUALITY, limit_px: int = LIMIT_PX) -> None:
        self._quality, self._limit_px = quality, limit_px

    def __call__(
        self, planes: Planes, chroma: tuple[int, int], bit_depth: int, tags: ColourTags
    ) -> bytes:
        """Encode a frame's planes; chroma, bit_depth, tags: the frame's.

        Raises UsageError as `preview_planes` does.
        """
        luma, *rest = preview_planes(planes, chroma, bit_depth, tags, JFIF, self._limit_px)
        if rest and chroma not in _KNOWN_CHROMA:
            size = -(-luma.shape[1] // 2), -(-luma.shape[0] // 2)
            rest = [cv2.resize(plane, size) for plane in rest]
        cb, cr = rest or (None, None)
        return bytes(simplejpeg.encode_jpeg_yuv_planes(luma, cb, cr, quality=self._quality))
