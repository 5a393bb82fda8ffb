"""The sink of a live run that makes JPEGs for the pages, while a page watches."""

from collections.abc import Callable
from fractions import Fraction

import numpy as np
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.live.interfaces import LivePicture
from makeup_video.web.session import Push, ShownPicture

_MICRO = Fraction(1, 1_000_000)
# (planes, chroma, bit_depth, tags) -> a JPEG that browsers show in the right colours
MakeJpeg = Callable[[tuple[np.ndarray, ...], tuple[int, int], int, ColourTags], bytes]


class PreviewSink:
    """A LiveSink for the pages. The server's thread sets `push` and `compares`."""

    name = kind = "preview"
    seconds = 0.0
    waiting = 1
    state = ""
    notice = ""  # pages show their own state

    def __init__(self, make_jpeg: MakeJpeg) -> None:
        self._make_jpeg = make_jpeg
        self.push: Push | None = None
        self.compares = False
        self.newest: LivePicture | None = None
        self.sent = 0

    def __call__(self, picture: LivePicture, /) -> None:
        self.newest = picture
        self.sent += 1
        push = self.push
        if push is None:
            return
        frame = picture.frame
        before = picture.before if self.compares else None
        push(
            ShownPicture(
                pts_us=int(frame.pts * frame.time_base / _MICRO),
                rotation_degrees=frame.rotation_degrees,
                jpeg=self._jpeg(picture, frame.planes),
                before=None if before is None else self._jpeg(picture, before),
            )
        )

    def finish(self, stopped: bool) -> None:
        """Do nothing: the pages keep the last picture."""

    def _jpeg(self, picture: LivePicture, planes: tuple[np.ndarray, ...]) -> bytes:
        frame = picture.frame
        return self._make_jpeg(planes, frame.chroma, frame.bit_depth, frame.tags)
