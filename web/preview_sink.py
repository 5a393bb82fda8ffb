"""The sink of a live run that makes the pictures for the pages, as long as a page watches."""

import math
import threading
import time
from collections.abc import Callable
from fractions import Fraction
from typing import Protocol

import numpy as np
from makeup_video.pipeline.errors import EncodeError
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.live.interfaces import LivePicture
from makeup_video.web.session import Packet, Push, ShownPicture, VideoPicture, Wanted

_MICRO = Fraction(1, 1_000_000)
# The least time between two key frames. A key frame has as much data as five other pictures, and a
# page that is slower than the others needs one after each picture that it missed.
KEY_SECONDS = 0.5
# (planes, chroma, bit_depth, tags) -> a JPEG that browsers show in the right colours
MakeJpeg = Callable[[tuple[np.ndarray, ...], tuple[int, int], int, ColourTags], bytes]


class MakeVideo(Protocol):
    """One stream of H.264: see pipeline/live/preview_video.py."""

    def __call__(
        self,
        planes: tuple[np.ndarray, ...],
        chroma: tuple[int, int],
        bit_depth: int,
        tags: ColourTags,
        key: bool,
        /,
    ) -> Packet: ...


class PreviewSink:
    """A LiveSink for the pages. The server's thread sets `push`, `compares` and `wanted`.

    open_video: opens a stream of H.264; None: pages get only JPEG.
    log: gets a line when H.264 fails, and pages get JPEG from then on.
    """

    name = kind = "preview"
    seconds = 0.0
    waiting = 1
    state = ""
    notice = ""  # pages show their own state

    def __init__(
        self,
        make_jpeg: MakeJpeg,
        open_video: Callable[[], MakeVideo] | None = None,
        log: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._make_jpeg, self._open_video, self._log = make_jpeg, open_video, log
        self.push: Push | None = None
        self.compares = False
        self.wanted = Wanted()
        self.newest: LivePicture | None = None
        self.sent = 0
        self._one_at_a_time = threading.Lock()
        self._painted: MakeVideo | None = None
        self._before: MakeVideo | None = None  # the stream without makeup, while a page compares
        self._number = 0
        self._last_key = -math.inf

    @property
    def has_video(self) -> bool:
        return self._open_video is not None

    def __call__(self, picture: LivePicture, /) -> None:
        self.newest = picture
        self.sent += 1
        self._show(picture)

    def show_again(self) -> None:
        """Push the newest picture once more, in the formats wanted now, on any thread."""
        if self.newest is not None:
            self._show(self.newest)

    def finish(self) -> None:
        """Do nothing: the pages keep the last picture."""

    def _show(self, picture: LivePicture) -> None:
        with self._one_at_a_time:
            push, wanted = self.push, self.wanted
            if push is None or not (wanted.jpeg or wanted.video):
                return
            frame = picture.frame
            before = picture.before if self.compares else None
            video = self._video(picture, before, wanted.key) if wanted.video else None
            jpeg = wanted.jpeg
            push(
                ShownPicture(
                    pts_us=int(frame.pts * frame.time_base / _MICRO),
                    rotation_degrees=frame.rotation_degrees,
                    jpeg=self._jpeg(picture, frame.planes) if jpeg else None,
                    before=self._jpeg(picture, before) if jpeg and before is not None else None,
                    video=video,
                )
            )

    def _jpeg(self, picture: LivePicture, planes: tuple[np.ndarray, ...]) -> bytes:
        frame = picture.frame
        return self._make_jpeg(planes, frame.chroma, frame.bit_depth, frame.tags)

    def _video(
        self, picture: LivePicture, before: tuple[np.ndarray, ...] | None, key: bool
    ) -> VideoPicture | None:
        """The packets of a picture; None once the encoder has failed."""
        if self._open_video is None:
            return None
        now = time.monotonic()
        key = key and now - self._last_key >= KEY_SECONDS
        frame = picture.frame
        rest = frame.chroma, frame.bit_depth, frame.tags, key
        try:
            self._painted = self._painted or self._open_video()
            painted = self._painted(frame.planes, *rest)
            bare: Packet | None = None
            if before is None:
                self._before = None
            else:
                self._before = self._before or self._open_video()
                bare = self._before(before, *rest)
        except EncodeError as error:
            self._open_video = None
            self._log(str(error))
            return None
        if painted[1]:
            self._last_key = now
        self._number += 1
        return VideoPicture(self._number, painted, bare)
