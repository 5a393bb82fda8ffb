"""Counts the work of painting a video; the counts do not depend on the machine or its load.

`tests/test_work_per_frame.py` compares every count with a limit, which reveals a more expensive
frame where times would only be noise.
"""

import gc
import linecache
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import islice
from pathlib import Path
from types import FrameType
from typing import Any
from unittest.mock import patch

import av
import cv2
import numpy as np
import pyopencl as cl
from makeup_video.benchmark.videos import frame_of
from makeup_video.pipeline.engine.machine import one_opencv_thread
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.faces.nets import load_nets
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.media.input_file import open_video
from makeup_video.pipeline.offline.stages import PaintRun

# OpenCV functions that return pictures.
_OPENCV_FUNCTIONS = ("remap", "warpAffine", "resize", "transform", "merge", "split", "cvtColor",
           "GaussianBlur", "blur", "convertScaleAbs")  # fmt: skip


def measure_work(clip: Path, look: Look, frames: int) -> dict[str, float]:
    """The mean work per frame over the first `frames` of a video; nothing is encoded.

    net_runs, and net_runs_<name> of each net.  kernels_launched.  work_items: total of these
    kernels.  bytes_converted: size of the pictures that OpenCV returned (crops, maps, blurs).
    frames_converted: whole frames that PyAV converted to another layout.  calls: calls of Python
    and C functions.
    """
    counted: Counter[str] = Counter()
    # whenever PyOpenCL makes a kernel, it tries names one after the other until one is free there
    linecache.clearcache()
    source = open_video(local_file(clip))
    try:
        stages = PaintRun(look)(source)
        with one_opencv_thread(), _counting(counted):
            done = 0
            for picture in islice(source.container.decode(source.video), frames):
                item: Any = frame_of(picture)
                with _calls(counted):
                    for _, stage in stages:
                        item = stage(item)
                        if item is None:
                            break
                done += 1
    finally:
        source.close()
    return {name: count / max(done, 1) for name, count in sorted(counted.items())}


@contextmanager
def _counting(counted: Counter[str]) -> Iterator[None]:
    """Count the work of nets, kernels and OpenCV within the block."""
    names = _names_of_nets()
    run, launch = Net.__call__, cl.enqueue_nd_range_kernel

    def counted_run(net: Net, rgb8: np.ndarray) -> dict[str, np.ndarray]:
        counted["net_runs"] += 1
        counted[f"net_runs_{names[id(net)]}"] += 1
        return run(net, rgb8)

    def counted_launch(queue: Any, kernel: Any, size: tuple[int, ...], *rest: Any) -> Any:
        counted["kernels_launched"] += 1
        counted["work_items"] += int(np.prod(size))
        return launch(queue, kernel, size, *rest)

    def counted_function(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            result = function(*arguments, **options)
            pictures = result if isinstance(result, (tuple, list)) else (result,)
            counted["bytes_converted"] += sum(picture.nbytes for picture in pictures)
            return result

        return call

    with ExitStack() as stack:
        stack.enter_context(patch.object(Net, "__call__", counted_run))
        stack.enter_context(patch.object(cl, "enqueue_nd_range_kernel", counted_launch))
        for name in _OPENCV_FUNCTIONS:
            function = counted_function(getattr(cv2, name))
            stack.enter_context(patch.object(cv2, name, function))
        yield


def _names_of_nets() -> dict[int, str]:
    return {id(net): name for name, net in vars(load_nets()).items() if isinstance(net, Net)}


@contextmanager
def _calls(counted: Counter[str]) -> Iterator[None]:
    """Count calls of Python and C functions on this thread, and conversions of whole frames."""

    def count(frame: FrameType, event: str, function: Any) -> None:
        if event in ("call", "c_call"):
            counted["calls"] += 1
        if event == "c_call" and isinstance(getattr(function, "__self__", None), av.VideoFrame):
            counted["frames_converted"] += function.__name__ in ("reformat", "to_ndarray", "to_rgb")

    before = sys.getprofile()
    # libraries of other tests, such as Hypothesis, add their own calls to the garbage collector
    gc.disable()
    sys.setprofile(count)
    try:
        yield
    finally:
        sys.setprofile(before)
        gc.enable()
