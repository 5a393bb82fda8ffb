"""The cost of painting by itself, for `makeup-video bench`.

One face fills half the height of the frame, and lips and eyes are painted with every effect that a
look can have. Faces are found beforehand, so that only the scene (surfaces and light) and the
composite are timed.
"""

import time
from collections import deque
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from statistics import mean, median
from typing import Any

import numpy as np
from makeup_video.benchmark.videos import frame_of, pictures
from makeup_video.kernels.program import Device
from makeup_video.pipeline.engine.machine import one_opencv_thread
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead

WARM_FRAMES = 10  # the first frames, which are not counted
_KERNEL_FRAMES = 40
_DECODED_AHEAD = 8  # frames, as in a run: when a frame is painted, it has left the nearer caches


def full_look() -> Look:
    """Lips and eyes with gloss, reflection and shimmer: the highest cost of a layer."""
    lips, eyes = KINDS["lipstick"], KINDS["eyeshadow"]
    return Look(
        lips=product(lips.first_rgb, "shimmer", lips.part),
        eyes=product(eyes.first_rgb, "shimmer", eyes.part),
        zone="full",
    )


def whole_look() -> Look:
    """A look with every kind of makeup, in the colours that the page begins with. Eyeshadow has
    three layers."""
    layers = []
    for kind in KINDS.values():
        worn = product(kind.first_rgb, kind.first_finish, kind.part)
        slots = ("outer", "crease", "lid") if kind.slots else (None,)
        layers += [Layer(kind.name, worn, {"slot": slot} if slot else kind.shown) for slot in slots]
    return Look(layers)


def paint_costs(clip: Path, rounds: int) -> dict[str, Any]:
    """CPU ms a frame to paint `full_look`; the cost of `whole_look` as a multiple of this; and the
    kernels' share."""
    faces = find_in(clip)
    pairs = [
        (paint_clip(clip, faces), paint_clip(clip, faces, whole_look())) for _ in range(rounds)
    ]
    full, whole = (_middle(list(side)) for side in zip(*pairs, strict=True))
    ratio = whole["together_ms"] / full["together_ms"]
    return {**full, "whole_look": ratio, "kernel": kernel_alone(clip, faces, full_look())}


def find_in(clip: Path) -> list[tuple[Face, ...]]:
    """The faces of each frame, smoothed as in a run."""
    find, smooth = FindFaces(), SmoothAhead()
    smoothed = [smooth(find(frame_of(picture))) for picture in pictures(clip)]
    items = [item for item in smoothed if item is not None] + list(smooth.drain())
    return [item.faces for item in items]


def paint_clip(
    clip: Path, faces: list[tuple[Face, ...]], look: Look | None = None
) -> dict[str, float]:
    """CPU ms a frame of scene and composite, including OpenCL's threads: medians and a mean.

    look: None stands for `full_look`.
    """
    build, composite = BuildScene(), Composite(look or full_look())
    times = []
    with one_opencv_thread():  # as in a run
        for item in _items(clip, faces):
            began = time.process_time()
            scene = build(item)
            between = time.process_time()
            composite(scene)
            times.append((between - began, time.process_time() - between))
    scene_ms, composite_ms = (
        np.array(part) * 1000 for part in zip(*times[WARM_FRAMES:], strict=True)
    )
    return {
        "scene_ms": median(scene_ms.tolist()),
        "composite_ms": median(composite_ms.tolist()),
        "together_ms": median((scene_ms + composite_ms).tolist()),
        "together_mean_ms": mean((scene_ms + composite_ms).tolist()),
    }


def kernel_alone(clip: Path, faces: list[tuple[Face, ...]], look: Look) -> dict[str, float]:
    """The kernels' share of a composite, as medians of frames.

    kernel_ms: CPU time of all threads, including the launches.  launches: number of kernel
    launches.  work_items: of all launches together.  painted_px: pixels whose luma changed.
    """
    build, composite = BuildScene(), Composite(look)
    frames: list[tuple[float, int, int, int]] = []
    with one_opencv_thread(), _watched_launches() as launches:
        for item in islice(_items(clip, faces), _KERNEL_FRAMES):
            before, scene = item.frame.planes[0].copy(), build(item)
            launches.clear()  # the scene has a kernel, too
            after = composite(scene).planes[0]
            kernel_ms, work_items = sum(ms for ms, _ in launches), sum(n for _, n in launches)
            painted_px = int(np.count_nonzero(before != after))
            frames.append((kernel_ms, len(launches), work_items, painted_px))
    names = ("kernel_ms", "launches", "work_items", "painted_px")
    return dict(zip(names, map(median, zip(*frames[1:], strict=True)), strict=True))


@contextmanager
def _watched_launches() -> Generator[list[tuple[float, int]], None, None]:
    """Collect (CPU ms, work-items) of every kernel launch, and wait until each launch is done."""
    launches: list[tuple[float, int]] = []

    @contextmanager
    def watch(device: Device, work_items: int) -> Generator[None, None, None]:
        began = time.process_time()
        yield
        device.finish()
        launches.append((1000 * (time.process_time() - began), work_items))

    Device.watch = watch
    try:
        yield launches
    finally:
        Device.watch = None


def _items(clip: Path, faces: list[tuple[Face, ...]]) -> Iterator[FrameFaces]:
    """The frames of a clip with their faces."""
    waiting: deque[Frame] = deque()
    of_frames = iter(faces)
    for picture in pictures(clip):
        waiting.append(frame_of(picture))
        if len(waiting) > _DECODED_AHEAD:
            yield FrameFaces(waiting.popleft(), next(of_frames))
    while waiting:
        yield FrameFaces(waiting.popleft(), next(of_frames))


def _middle(runs: list[dict[str, float]]) -> dict[str, float]:
    return {name: median(run[name] for run in runs) for name in runs[0]}
