"""Paints a moving portrait for two seconds, to test whether this machine can, and how fast."""

import io
import math
import time
from collections import defaultdict
from dataclasses import dataclass
from fractions import Fraction
from statistics import median

import av
import cv2
import numpy as np
from makeup_video.pipeline.engine.machine import one_opencv_thread
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.ready import ready_look
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.smoothing.realtime import SmoothLive
from makeup_video.web.portrait import OWN

WIDTH_PX, HEIGHT_PX, FPS = 1280, 720, 30
_PATH_PX = 40  # how far the portrait moves to each side
_FACE_SHARE = 0.75  # height of the portrait as a share of the frame's height
_VIDEO = ColourTags(1, 1, 1, 1)


@dataclass(frozen=True, slots=True)
class SelfTest:
    """What a self-test measured.

    start_seconds: the time to load the nets, open the device and paint the first frame.
    frames: how many frames followed.  painted: how many frames, with the first, had a painted face.
    stages_ms: median time of each stage for a frame, including the encoder.
    """

    start_seconds: float
    frames: int
    painted: int
    stages_ms: dict[str, float]

    @property
    def fps(self) -> float:
        """Frames per second if one stage ran after the other."""
        return 1000 / sum(self.stages_ms.values())


def self_test(device: str = "", seconds: float = 2.0) -> SelfTest:
    """Find faces in 720p frames, smooth, paint and encode them.

    seconds: about how long, after the first frame.  device: as for `open_device`.  Raises
    InstallError, UsageError, OutputError.
    """
    times: dict[str, list[float]] = defaultdict(list)
    began = time.perf_counter()
    look = ready_look("smoky-brown").look
    composite = Composite(look, device)
    stages = {
        "faces": FindFaces(), "smooth": SmoothLive(), "scene": BuildScene(device),
        "composite": composite, "encode": _Encoder(),
    }  # fmt: skip
    source = _Frames()
    start, count = 0.0, 0
    with one_opencv_thread():
        while count < 2 or time.perf_counter() - began - start < seconds:
            item: object = source(count)
            for name, stage in stages.items():
                at = time.perf_counter()
                item = stage(item)  # type: ignore[operator]
                times[name].append(1000 * (time.perf_counter() - at))
            start = start or time.perf_counter() - began
            count += 1
    stages_ms = {name: median(values[1:]) for name, values in times.items()}
    return SelfTest(start, count - 1, composite.painted_frames, stages_ms)


class _Frames:
    """Frames of a portrait that moves to and fro."""

    def __init__(self) -> None:
        bgr8 = cv2.imread(str(OWN))
        assert bgr8 is not None, OWN
        scale = HEIGHT_PX * _FACE_SHARE / bgr8.shape[0]
        self._portrait = cv2.resize(bgr8, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)

    def __call__(self, number: int) -> Frame:
        height, width = self._portrait.shape[:2]
        shown = np.full((HEIGHT_PX, WIDTH_PX, 3), 128, np.uint8)
        x = (WIDTH_PX - width) // 2 + round(_PATH_PX * math.sin(2 * math.pi * number / 60))
        y = (HEIGHT_PX - height) // 2
        shown[y : y + height, x : x + width] = self._portrait
        picture = av.VideoFrame.from_ndarray(shown, format="bgr24").reformat(format="yuv420p")
        picture.pts, picture.time_base = number, Fraction(1, FPS)
        return Frame(picture, number, Fraction(1, FPS), _VIDEO)


class _Encoder:
    """H.264 at the default settings of `makeup-video`, into memory."""

    def __init__(self) -> None:
        self._out = av.open(io.BytesIO(), "w", format="matroska")
        self._stream = self._out.add_stream("libx264", rate=FPS)
        self._stream.width, self._stream.height = WIDTH_PX, HEIGHT_PX
        self._stream.options = {"crf": "18", "preset": "veryfast"}

    def __call__(self, frame: Frame) -> None:
        self._out.mux(self._stream.encode(frame.picture))
