"""What painting costs: the part of `makeup-video bench` about the renderer. Plain numbers again.

One face that fills half the height of its frame, lips and eyes painted with everything on. Faces are
found beforehand, so that only the scene (surfaces and light) and the composite are timed.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from statistics import mean, median
from typing import Any
from unittest.mock import patch

import av
import numpy as np
from makeup_video.kernels.colour import SRGB
from makeup_video.kernels.paint import paint
from makeup_video.pipeline import composite as composite_module
from makeup_video.pipeline.composite import Composite
from makeup_video.pipeline.crop import compose
from makeup_video.pipeline.errors import InputError
from makeup_video.pipeline.face import Face, FrameFaces, LipPatch
from makeup_video.pipeline.face_run import one_opencv_thread
from makeup_video.pipeline.faces import FindFaces, find_faces_in_frame
from makeup_video.pipeline.finishes import product
from makeup_video.pipeline.frame import ColourTags, Frame
from makeup_video.pipeline.look import Look
from makeup_video.pipeline.mesh import BuildScene
from makeup_video.pipeline.smooth import SmoothAhead

WARM_FRAMES = 10  # not counted
LARGER = 3  # times as wide and high is the frame that the same face is pasted into
# Counted in kernels/paint.cl and its headers for SDR: 160 between codes and light, 90 for the surface and
# what it mirrors, 70 for shimmer, 170 for the product. Roots and divisions count as one.
OPERATIONS_PER_PX = 490
_REPEATS = 200
_HELD_BACK = 8  # frames decoded ahead, as in a run: what is painted has left the nearer caches
_FOREHEAD, _CHIN = 10, 152


def full_look() -> Look:
    """Lips and eyes with gloss, reflection and shimmer: everything that a look can cost."""
    lips = replace(product((180, 0, 46), "gloss"), shimmer=0.5)
    eyes = replace(product((90, 40, 120), "shimmer", "eyes"), reflection=0.2)
    return Look(lips=lips, eyes=eyes, zone="full")


def measure_renderer(
    source: Path, folder: Path, heights: list[int], frames: int, rounds: int
) -> dict[str, Any]:
    """Everything below, on the first `frames` frames of a clip with a face."""
    results: dict[str, Any] = {"sizes": {}}
    for height in heights:
        clip = make_face_clip(source, folder / f"face{height}.mkv", height, frames)
        faces = find_in(clip)
        times = [paint_clip(clip, faces) for _ in range(rounds)]
        results["sizes"][f"{height}p"] = {
            **_middle(times),
            "kernel": kernel_beside_floor(clip, faces),
        }
    clip = folder / f"face{heights[0]}.mkv"
    faces = find_in(clip)
    larger, there = paste_into_larger(clip, folder / "larger.mkv", faces)
    pairs = [(paint_clip(clip, faces), paint_clip(larger, there)) for _ in range(rounds)]
    same, more = (_middle(list(side))["together_ms"] for side in zip(*pairs, strict=True))
    results["larger_frame_ratio"] = more / same
    results["start"] = start_of_painting(clip)
    return results


def make_face_clip(source: Path, target: Path, height_px: int, frames: int) -> Path:
    """The clip, scaled and cut so that its face is half the height and stays in the middle."""
    pictures = list(_pictures(source, frames))
    found = [find_faces_in_frame(_frame(pictures[at]))[0].faces for at in (0, len(pictures) // 2)]
    if not all(found):
        raise InputError(f"{source} shows no face to paint on: give a clip of somebody")
    ends = np.mean([faces[0].points_px[[_FOREHEAD, _CHIN], :2] for faces in found], axis=0)
    scale = height_px / 2 / float(np.linalg.norm(ends[0] - ends[1]))
    width_px = round(height_px * 8 / 9) * 2
    x, y = ends.mean(0) * scale - (width_px / 2, height_px / 2)

    def cut(picture: av.VideoFrame) -> np.ndarray:
        size = round(picture.width * scale / 2) * 2, round(picture.height * scale / 2) * 2
        plane = picture.reformat(*size, format="yuv444p").to_ndarray()
        rows = np.clip(np.arange(height_px) + round(y), 0, size[1] - 1)
        columns = np.clip(np.arange(width_px) + round(x), 0, size[0] - 1)
        return np.ascontiguousarray(plane[:, rows[:, None], columns])

    return _write(target, map(cut, pictures))


def paste_into_larger(
    clip: Path, target: Path, faces: list[tuple[Face, ...]]
) -> tuple[Path, list[tuple[Face, ...]]]:
    """The same pixels in the middle of a frame LARGER times as wide and high, and where its faces are."""
    around: tuple[int, int] = (0, 0)

    def paste(picture: av.VideoFrame) -> np.ndarray:
        nonlocal around
        planes = picture.reformat(format="yuv444p").to_ndarray()
        around = tuple((LARGER - 1) * length // 4 * 2 for length in planes.shape[1:])
        return np.pad(planes, ((0, 0), *((one, one) for one in around)), mode="edge")

    _write(target, (paste(picture) for picture in _pictures(clip, len(faces))))
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
    smoothed = [smooth(find(_frame(picture))) for picture in _pictures(clip)]
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


def kernel_beside_floor(clip: Path, faces: list[tuple[Face, ...]]) -> dict[str, float]:
    """The kernel over the windows of one frame, beside what its bytes and its arithmetic must cost.

    window_px: pixels worked on; painted_px: those with weight.  kernel_ms: CPU time, launches
    included.  copy_ms: to copy as many bytes as it reads and writes.  arithmetic_ms: as many
    operations, multiplied and added in pairs, as OPERATIONS_PER_PX says.
    """
    calls: list[tuple[Any, ...]] = []
    build, composite = BuildScene(), Composite(full_look())
    with patch.object(composite_module, "paint", lambda *call: calls.append(call)):
        composite(build(next(_items(clip, faces))))
    lumas = [luma for _, luma, *_ in calls]
    window_px = sum(luma.size for luma in lumas)
    # luma, chroma (f32) read and written; four maps (f32) read
    moved_bytes = sum(luma.size * (2 * luma.itemsize + 4 * 4 + 4 * 4) for luma in lumas)
    there, back = np.ones(moved_bytes // 2, np.uint8), np.empty(moved_bytes // 2, np.uint8)

    def paint_all() -> None:
        for call in calls:
            paint(*call)

    operations = window_px * OPERATIONS_PER_PX
    return {
        "window_px": window_px,
        "painted_px": sum(int(np.count_nonzero(call[3].maps[0])) for call in calls),
        "moved_bytes": moved_bytes,
        "operations": operations,
        "kernel_ms": _least_ms(paint_all),
        "copy_ms": _least_ms(lambda: np.copyto(back, there)),
        "arithmetic_ms": operations / _peak_operations_per_ms(calls[0][0]),
    }


def _peak_operations_per_ms(device: Any) -> float:
    """Multiplications and additions, in pairs and all independent, in a ms of CPU time."""
    count, chains, repeats = 4096, 6, 32
    step = " ".join(f"a{i} = a{i} * factor + 1.0f;" for i in range(chains))
    source = (
        "__kernel void peak(__global float *restrict out, const float factor) {"
        " int x = get_global_id(0);"
        + "".join(f" float a{i} = (float)(x + {i});" for i in range(chains))
        + step * repeats
        + " out[x] = " + " + ".join(f"a{i}" for i in range(chains)) + "; }"
    )  # fmt: skip
    kernel = device.build(source, SRGB).peak
    out = np.zeros((1, count), np.float32)

    def run() -> None:
        with device.lend(out) as buffers:
            for _ in range(16):
                device.launch(kernel, (count, 1), [*buffers, np.float32(0.5)])

    return 16 * count * chains * repeats * 2 / _least_ms(run)


def _least_ms(work: Callable[[], object]) -> float:
    """CPU time of the least of many repeats."""
    times = []
    for _ in range(_REPEATS):
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return 1000 * min(times)


def _items(clip: Path, faces: list[tuple[Face, ...]]) -> Iterator[FrameFaces]:
    waiting: deque[Frame] = deque()
    given = iter(faces)
    for picture in _pictures(clip):
        waiting.append(_frame(picture))
        if len(waiting) > _HELD_BACK:
            yield FrameFaces(waiting.popleft(), next(given))
    while waiting:
        yield FrameFaces(waiting.popleft(), next(given))


def _frame(picture: av.VideoFrame) -> Frame:
    assert picture.pts is not None and picture.time_base is not None
    return Frame(picture, picture.pts, picture.time_base, ColourTags.of(picture))


def _pictures(clip: Path, count: int | None = None) -> Iterator[av.VideoFrame]:
    """Decoded by one thread, so that nothing else runs while painting is timed."""
    with av.open(str(clip)) as box:
        video = box.streams.video[0]
        video.thread_type, video.codec_context.thread_count = "NONE", 1
        for number, picture in enumerate(box.decode(video)):
            if number == count:
                return
            yield picture


def _write(target: Path, pictures: Iterator[np.ndarray]) -> Path:
    """(3, H, W) uint8 Y'CbCr -> a film in 4:2:0."""
    with av.open(str(target), "w") as out:
        stream: Any = None
        for index, planes in enumerate(pictures):
            if stream is None:
                stream = out.add_stream(
                    "libx264", rate=30, options={"preset": "ultrafast", "crf": "12"}
                )
                stream.height, stream.width = planes.shape[1:]
                stream.pix_fmt = "yuv420p"
            picture = av.VideoFrame.from_ndarray(planes, format="yuv444p").reformat(
                format="yuv420p"
            )
            picture.pts, picture.time_base = index, Fraction(1, 30)
            out.mux(stream.encode(picture))
        out.mux(stream.encode(None))
    return target


def _middle(runs: list[dict[str, float]]) -> dict[str, float]:
    return {name: median(run[name] for run in runs) for name in runs[0]}


def start_of_painting(clip: Path) -> dict[str, float]:
    """Seconds from making a Composite to its first painted frame, less what a later frame takes.

    first: kernels are compiled; later: in another process, with what PoCL then kept on disk.
    """
    code = "from makeup_video.cli.measure_renderer import print_start; print_start()"
    with tempfile.TemporaryDirectory(prefix="makeup-video-pocl-") as cache:
        environment = {**os.environ, "POCL_CACHE_DIR": cache}

        def start() -> float:
            words = [sys.executable, "-c", code, str(clip)]
            return float(subprocess.check_output(words, env=environment))

        return {"first_seconds": start(), "later_seconds": median(start() for _ in range(3))}


def print_start() -> None:
    """In a process of its own: the clip is its argument."""
    clip = Path(sys.argv[1])
    frames = [_frame(picture) for picture in _pictures(clip, 3)]
    build = BuildScene()
    scenes = [build(find_faces_in_frame(frame)[0]) for frame in frames]
    began = time.perf_counter()
    composite = Composite(full_look())
    composite(scenes[0])
    first = time.perf_counter() - began
    warm = []
    for scene in scenes[1:]:
        began = time.perf_counter()
        composite(scene)
        warm.append(time.perf_counter() - began)
    print(first - min(warm))
