"""What painting costs: the part of `makeup-video bench` about the renderer. Plain numbers again.

One face that fills half the height of its frame, lips and eyes painted with everything on. Faces are
found beforehand, so that only the scene (surfaces and light) and the composite are timed.
"""

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from statistics import mean, median
from typing import Any
from unittest.mock import patch

import av
import numpy as np
from makeup_video.benchmark.films import LIKE_A_FILM, frame_of, pictures, write_film
from makeup_video.kernels.program import Device
from makeup_video.pipeline.engine.machine import one_opencv_thread
from makeup_video.pipeline.faces.face import Face, FrameFaces, LipPatch
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.affine import compose
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead

WARM_FRAMES = 10  # not counted
LARGER = 3  # times as wide and high is the frame that the same face is pasted into
_KERNEL_FRAMES = 40
_HELD_BACK = 8  # frames decoded ahead, as in a run: what is painted has left the nearer caches


def full_look() -> Look:
    """Lips and eyes with gloss, reflection and shimmer: everything that a look can cost."""
    lips = replace(product((180, 0, 46), "gloss"), shimmer=0.5)
    eyes = replace(product((90, 40, 120), "shimmer", "eyes"), reflection=0.2)
    return Look(lips=lips, eyes=eyes, zone="full")


def paint_costs(clip: Path, rounds: int) -> dict[str, Any]:
    """CPU ms a frame of painting with everything on."""
    faces = find_in(clip)
    times = [paint_clip(clip, faces) for _ in range(rounds)]
    return {**_middle(times), "kernel": kernel_alone(clip, faces, full_look())}


def larger_frame_ratio(clip: Path, folder: Path, rounds: int) -> float:
    """What the same faces cost in a frame LARGER times as wide and high, by what they cost here."""
    faces = find_in(clip)
    larger, there = paste_into_larger(clip, folder / "larger.mkv", faces)
    pairs = [(paint_clip(clip, faces), paint_clip(larger, there)) for _ in range(rounds)]
    same, more = (_middle(list(side))["together_ms"] for side in zip(*pairs, strict=True))
    return more / same


def paste_into_larger(
    clip: Path, target: Path, faces: list[tuple[Face, ...]]
) -> tuple[Path, list[tuple[Face, ...]]]:
    """The same pixels in the middle of a frame LARGER times as wide and high, and where its faces are."""
    around: tuple[int, int] = (0, 0)

    def paste(picture: av.VideoFrame) -> av.VideoFrame:
        nonlocal around
        planes = picture.reformat(format="yuv444p").to_ndarray().astype(np.uint8, copy=False)
        around = tuple((LARGER - 1) * length // 4 * 2 for length in planes.shape[1:])
        whole = np.pad(planes, ((0, 0), *((one, one) for one in around)), mode="edge")
        return av.VideoFrame.from_ndarray(whole, format="yuv444p").reformat(format="yuv420p")

    write_film(target, map(paste, pictures(clip, len(faces))), LIKE_A_FILM)
    shift = np.array([[1.0, 0, around[1]], [0, 1, around[0]]])

    def moved(face: Face) -> Face:
        points = face.points_px + np.array([*around[::-1], 0], np.float32)
        return replace(
            face, points_px=points, lips=LipPatch(face.lips.logits, compose(shift, face.lips.to_px))
        )

    return target, [tuple(moved(face) for face in there) for there in faces]


def find_in(clip: Path) -> list[tuple[Face, ...]]:
    """The faces of each frame, steadied as in a run."""
    find, smooth = FindFaces(), SmoothAhead()
    smoothed = [smooth(find(frame_of(picture))) for picture in pictures(clip)]
    items = [item for item in smoothed if item is not None] + list(smooth.drain())
    return [item.faces for item in items]


def paint_clip(clip: Path, faces: list[tuple[Face, ...]]) -> dict[str, float]:
    """CPU ms a frame of scene and composite, the threads of OpenCL included: medians and means."""
    build, composite = BuildScene(), Composite(full_look())
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
    """What the kernels take of a composite: medians of frames.

    kernel_ms: CPU time of all threads, launches included.  launches: of kernels.  work_items: theirs.
    painted_px: those whose luma changed.
    """
    build, composite, launch = BuildScene(), Composite(look), Device.launch
    frames: list[tuple[float, int, int, int]] = []
    notes: list[tuple[float, int]] = []

    def noted(device: Device, kernel: Any, size_wh: tuple[int, int], *rest: Any) -> None:
        began = time.process_time()
        launch(device, kernel, size_wh, *rest)
        device.queue.finish()
        notes.append((1000 * (time.process_time() - began), size_wh[0] * size_wh[1]))

    with one_opencv_thread(), patch.object(Device, "launch", noted):
        for item in islice(_items(clip, faces), _KERNEL_FRAMES):
            before, scene = item.frame.planes[0].copy(), build(item)
            notes.clear()  # the scene has a kernel too
            after = composite(scene).planes[0]
            painted = int(np.count_nonzero(before != after))
            frames.append(
                (sum(ms for ms, _ in notes), len(notes), sum(n for _, n in notes), painted)
            )
    names = ("kernel_ms", "launches", "work_items", "painted_px")
    return dict(zip(names, map(median, zip(*frames[1:], strict=True)), strict=True))


def _items(clip: Path, faces: list[tuple[Face, ...]]) -> Iterator[FrameFaces]:
    waiting: deque[Frame] = deque()
    given = iter(faces)
    for picture in pictures(clip):
        waiting.append(frame_of(picture))
        if len(waiting) > _HELD_BACK:
            yield FrameFaces(waiting.popleft(), next(given))
    while waiting:
        yield FrameFaces(waiting.popleft(), next(given))


def _middle(runs: list[dict[str, float]]) -> dict[str, float]:
    return {name: median(run[name] for run in runs) for name in runs[0]}
