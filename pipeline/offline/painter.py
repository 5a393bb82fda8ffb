"""Paints RGB frames that come one after the other, with the tracking and smoothing of a video."""

import math
import threading
from collections import deque
from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import NoReturn, SupportsFloat, SupportsIndex

import numpy as np
from makeup_video.pipeline.engine.machine import one_opencv_thread
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.rgb_frame import RgbFrame
from makeup_video.pipeline.frames.views import check_paintable
from makeup_video.pipeline.look.look import Look, check_look
from makeup_video.pipeline.offline.settings import check_whom, choice, is_number
from makeup_video.pipeline.render.apply_look import PaintPictures
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead
from makeup_video.pipeline.smoothing.realtime import SmoothLive

_FPS = 30.0
_MOST_SECONDS = 1e12  # RgbFrame counts microseconds, in 64 bits


class Painter:
    """Paints a look on the frames of one video, each as soon as it comes.

    look: may be changed between two frames; faces and device may not.  faces: "all", "largest", or
    the number of a face, in the order in which faces appear, as `inspect_video` draws it.
    device: the OpenCL device that paints, by its number or a part of its name; "": the processor.
    painted_frames: how many frames had a face that was painted, in all videos.
    found: the faces of the last frame, largest first, each with its number, `track_id`. Empty after
    a frame with a bare look, since such a frame is not searched for faces.

    Faces are followed from frame to frame and smoothed without delay, as `makeup-video live` does.
    A time that is not later than the last, or another size, begins a new video.
    Only one thread at a time may use a painter.  Raises TypeError for a look of a wrong type,
    UsageError, and InstallError when the face nets or OpenCL are missing.
    """

    # without slots `painter.faces = ...` would pass, and change nothing
    __slots__ = (
        "__weakref__", "_alone", "_composite", "_device", "_find", "_found", "_last_seconds",
        "_scene", "_size_wh", "_smooth",
    )  # fmt: skip

    def __init__(
        self, look: Look, *, faces: str | int | None = "all", device: str | int | None = ""
    ) -> None:
        check_look(look)
        whom, self._device = choice("faces", faces), choice("device", device)
        check_whom(whom)
        self._composite = Composite(look, self._device, whom)
        self._alone = threading.Lock()
        self._size_wh = (0, 0)
        self._last_seconds = math.inf
        self._begin()

    def _begin(self) -> None:
        """Forget every face."""
        self._found: tuple[Face, ...] = ()
        self._find, self._smooth = FindFaces(), SmoothLive()
        self._scene = BuildScene(self._device)
        self._composite.forget()

    @property
    def look(self) -> Look:
        return self._composite.look

    @look.setter
    def look(self, look: Look) -> None:
        check_look(look)
        self._composite.set_look(look)

    @property
    def painted_frames(self) -> int:
        return self._composite.painted_frames

    @property
    def found(self) -> tuple[Face, ...]:
        return self._found

    def __reduce_ex__(self, protocol: SupportsIndex) -> NoReturn:
        """Refuse `copy` and `pickle`: a copy would share the kernels and the tracked faces."""
        raise TypeError("a painter cannot be copied or pickled: make another")

    def __call__(self, rgb8: np.ndarray, seconds: SupportsFloat) -> np.ndarray:
        """The frame with the look painted on its faces; other pixels keep their values.

        rgb8: (H, W, 3) uint8, upright, R'G'B' as sRGB encodes it; it is not changed.
        seconds: the frame's time, later than the time of the frame before. An earlier or equal
        time, or another size, begins a new video, in which faces are found and numbered anew.
        Returns a new (H, W, 3) uint8 array, encoded like rgb8.  Raises ValueError for another
        shape or dtype, and for a time that is not finite; TypeError for a time that is not a
        number; RuntimeError while another thread uses this painter.
        """
        exact = check_frame(rgb8, seconds)
        if not self._alone.acquire(blocking=False):  # OpenCL would crash
            raise RuntimeError("a painter serves one thread at a time: make one for each thread")
        try:
            return self._paint(rgb8, exact)
        finally:
            self._alone.release()

    def _paint(self, rgb8: np.ndarray, seconds: float) -> np.ndarray:
        size_wh = rgb8.shape[1], rgb8.shape[0]
        if seconds <= self._last_seconds or size_wh != self._size_wh:
            self._begin()
        self._last_seconds, self._size_wh = seconds, size_wh
        if self.look.is_bare:
            self._found = ()
            return np.array(rgb8, order="C")
        with one_opencv_thread():
            opened = RgbFrame(rgb8, seconds)
            smoothed = self._smooth(self._find(opened.frame))
            self._composite(self._scene(smoothed))
            self._found = smoothed.faces
            return opened.painted()


def paint_frames(
    frames: Iterable[np.ndarray] | Iterable[tuple[np.ndarray, SupportsFloat]],
    look: Look,
    *,
    fps: float | Fraction = _FPS,
    faces: str | int | None = "all",
    device: str | int | None = "",
) -> Iterator[np.ndarray]:
    """Paint the frames of a video; yields one painted frame for each, in order.

    frames: (H, W, 3) uint8 arrays, upright, R'G'B' as sRGB encodes it, all of one size, `fps` of
    them per second; or pairs of such an array and its time in seconds, with rising times.  They are
    read a few frames ahead, so that faces are smoothed without lag, as in `process_video`. Each
    array may be reused as soon as the next one is asked for.
    faces, device: as for Painter.
    Yields new arrays, encoded like the frames.  Raises TypeError, and UsageError for `faces`, at
    once; InstallError, and UsageError for `device`, with the first frame; ValueError for a wrong
    shape, dtype, size or order of times while frames are read.
    """
    check_look(look)
    whom = choice("faces", faces)
    check_whom(whom)
    _check_several(frames, "frames")
    if not is_number(fps):
        raise TypeError(f"fps must be a number, got {fps!r}")
    if not (math.isfinite(fps) and fps > 0):
        raise ValueError(f"fps must be more than 0, got {fps}")
    return _painted(_timed(frames, fps), look, whom, choice("device", device))


def paint_pictures(pictures: Iterable[np.ndarray], look: Look) -> Iterator[np.ndarray]:
    """Paint pictures that have nothing to do with each other; yields one for each, in order.

    pictures: as for `apply_look`. This does the same for many, and loads the kernels only once.
    Raises TypeError, and ValueError for a single picture, at once; ValueError or InstallError while
    pictures are read.
    """
    check_look(look)
    _check_several(pictures, "pictures")
    paint = PaintPictures()
    return (paint(rgb8, look) for rgb8 in pictures)


def _check_several(pictures: object, name: str) -> None:
    """Raises TypeError unless these can be several pictures, ValueError for a single one."""
    if not isinstance(pictures, Iterable):
        raise TypeError(
            f"{name} must be several arrays, got {type(pictures).__name__}: put it in []"
        )
    if isinstance(pictures, np.ndarray) and pictures.ndim == 3:
        raise ValueError(
            f"{name} must be several pictures, got one of shape {pictures.shape}: apply_look "
            "paints one"
        )


def check_frame(rgb8: np.ndarray, seconds: SupportsFloat) -> float:
    """The time of a frame as a float, whatever its type of number.

    Raises ValueError unless rgb8 is an (H, W, 3) uint8 picture and the time is at most 1e12 s,
    TypeError for a time that is not a number.
    """
    check_paintable(rgb8)
    if not is_number(seconds):
        raise TypeError(f"the time of a frame must be a number of seconds, got {seconds!r}")
    exact = float(seconds)
    if not abs(exact) <= _MOST_SECONDS:
        raise ValueError(
            f"the time of a frame must be a finite number of seconds, at most {_MOST_SECONDS:g}, "
            f"got {seconds}"
        )
    return exact


def _timed(
    frames: Iterable[np.ndarray] | Iterable[tuple[np.ndarray, SupportsFloat]],
    fps: float | Fraction,
) -> Iterator[tuple[np.ndarray, float]]:
    """Every frame with its time. Raises ValueError."""
    size: tuple[int, ...] = ()
    last = -math.inf
    for number, item in enumerate(frames):
        pair = item if isinstance(item, tuple | list) else (item, number / fps)
        if len(pair) != 2:
            _refuse(number, f"give a picture, or a picture and its seconds, got {len(pair)} items")
        rgb8, seconds = pair
        try:
            seconds = check_frame(rgb8, seconds)
        except (TypeError, ValueError) as error:
            _refuse(number, str(error), type(error))
        if seconds <= last:
            _refuse(number, f"its time must be later than {last:g} s, got {seconds:g} s")
        if size and rgb8.shape != size:
            _refuse(number, f"its shape must be that of the first, {size}, got {rgb8.shape}")
        last, size = seconds, rgb8.shape
        yield rgb8, seconds


def _refuse(number: int, reason: str, kind: type[Exception] = ValueError) -> NoReturn:
    raise kind(f"frame {number}: {reason}") from None


def _painted(
    frames: Iterator[tuple[np.ndarray, float]], look: Look, faces: str, device: str
) -> Iterator[np.ndarray]:
    if look.is_bare:
        yield from (np.array(rgb8, order="C") for rgb8, _ in frames)
        return
    find, smooth, scene = FindFaces(), SmoothAhead(), BuildScene(device)
    composite = Composite(look, device, faces)
    held: deque[RgbFrame] = deque()  # frames whose faces `smooth` still holds

    def painted(item: FrameFaces) -> np.ndarray:
        composite(scene(item))
        return held.popleft().painted()

    def follow(frame: Frame) -> np.ndarray | None:
        item = smooth(find(frame))
        return None if item is None else painted(item)

    for rgb8, seconds in frames:
        # not around `yield`: between two frames the caller has all of OpenCV's threads
        with one_opencv_thread():
            held.append(RgbFrame(rgb8, seconds))
            done = follow(held[-1].frame)
        if done is not None:
            yield done
    for item in smooth.drain():
        with one_opencv_thread():
            done = painted(item)
        yield done
