"""`makeup-video bench --live`: how late and how steadily a camera's picture reaches a page.

A video plays in real time as the camera, in a process of its own with the page's server
(live_process.py). A viewer in another process (live_viewer.py) takes every picture. The latency of
a frame is the time from its arrival until the viewer has its painted picture. Each size is played
twice: once with JPEG, which a page on the same machine gets, and once with H.264, which a page on
another machine gets. On request the page itself is measured in Chromium, too (live_browser.py).
"""

import json
import math
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from makeup_video.benchmark.runs import check_painted
from makeup_video.benchmark.videos import RATE, repeat_video
from makeup_video.pipeline.errors import OutputError, option

if TYPE_CHECKING:
    from makeup_video.benchmark.harness import Bench

WARM_SECONDS = 1.0  # from the first frame on, not counted: caches are cold, threads start
ENDS_SECONDS = 10.0  # the beginning and the end of the run that are reported separately
_STAGES = ("work", "faces", "smooth", "scene", "composite", "preview")
# Columns of the table of frames: pts in microseconds, all others in monotonic seconds.
COLUMNS = ("pts", "came", *(f"{name} {what}" for name in _STAGES for what in ("begins", "ends")))
KINDS = {"jpeg": "", "h264": ", H.264"}  # kinds of pictures, and what tables add to the size
VIEWERS = {"live_viewer": "", "live_browser": ", Chromium"}  # modules, and what tables add
FRAMES, SAMPLES, VIEWED = "frames.npy", "samples.npy", "viewed.npy"


def measure_live(
    bench: "Bench", heights: list[int], minutes: float, chromium: bool = False
) -> dict[str, Any]:
    """Measure live runs; the result has the figures of every size and kind of picture in "sizes".

    chromium: measure the page in Chromium, too.
    """
    seconds = (60 * minutes or bench.seconds) + WARM_SECONDS
    sizes = {}
    for height in heights:
        made = bench.video(height, min(seconds, bench.seconds), loops=True)
        times = math.ceil(seconds * RATE / made.frames)
        video = repeat_video(made.path, bench.folder / f"live{height}.mp4", times)
        for viewer, by in VIEWERS.items():
            if viewer == "live_browser" and not chromium:
                continue
            for kind, words in KINDS.items():
                size = f"{height}p{words}{by}"
                bench.log(f"{size}: {made.frames * times / RATE:.0f} s live")
                played = _play(bench, video, made.frames * times, kind, viewer)
                sizes[size] = {"film": made.description, **played}
        video.unlink()
    return {"sizes": sizes}


def _play(bench: "Bench", video: Path, frames: int, kind: str, viewer: str) -> dict[str, Any]:
    with TemporaryDirectory(dir=bench.folder) as name:
        folder = Path(name)
        bench.look.save(folder / "look.json")
        command = [sys.executable, "-m", "makeup_video.benchmark.live_process"]
        command += [str(video), str(folder / "look.json"), str(folder), kind, viewer]
        result = subprocess.run(
            command, check=True, stdout=subprocess.PIPE, stderr=bench.child_stderr
        ).stdout
        tables = [np.load(folder / table) for table in (FRAMES, SAMPLES, VIEWED)]
    values = json.loads(result)
    check_painted(round(values["painted_share"] * frames), frames)
    return {**figures(*tables), **values}


def figures(frames: np.ndarray, samples: np.ndarray, viewed: np.ndarray) -> dict[str, Any]:
    """The figures of a run: latency, dropped frames, stages, CPU time and memory.

    frames: (N, len(COLUMNS)) float64, NaN: never.  samples: (M, 3) float64: monotonic seconds, MB
    in memory (NaN: unknown), CPU seconds.  viewed: as live_viewer.watch writes it.

    dropped: frames that were due but never reached the viewer. The file that acts as the camera
    drops frames when it is late; the run drops a frame before painting when a newer frame arrives;
    the preview drops the rest.  Raises OutputError when the viewer had none of the counted frames.
    """
    began = frames[0, 1] + WARM_SECONDS
    counted = frames[frames[:, 1] >= began]
    due = counted[:, 0] / 1e6
    pictures = viewed[:-1]
    viewed_at = dict(pictures[:, :2])
    shown_at = dict(pictures[:, ::2])
    seen = _seen(counted, viewed_at)
    if np.isnan(seen).all():
        raise OutputError(
            f"the viewer had none of {len(counted)} pictures in time: make the video longer "
            f"({option('seconds', 20)}), or close other programs"
        )
    painted = _column(counted, "work ends")
    latency = _latency_ms(counted, viewed_at)
    last = counted[-1, 1]
    camera = round((due[-1] - due[0]) * RATE) - (len(due) - 1)
    before_painting = int(np.isnan(painted).sum())
    preview = int(np.isnan(seen[~np.isnan(painted)]).sum())
    return {
        "warm_up_seconds": WARM_SECONDS,
        "warm_up_latency_ms": _spread(_latency_ms(frames[frames[:, 1] < began], viewed_at)),
        "seconds": last - began,
        "frames": len(counted),
        "fps": float((~np.isnan(seen)).sum() - 1) / float(np.nanmax(seen) - np.nanmin(seen)),
        "latency_ms": _spread(latency),
        "decoded_latency_ms": _spread(_latency_ms(counted, shown_at)),
        "bytes_per_picture": float(pictures[:, 3].mean()) if len(pictures) else math.nan,
        "first_seconds_latency_ms": _spread(latency[counted[:, 1] < began + ENDS_SECONDS]),
        "last_seconds_latency_ms": _spread(latency[counted[:, 1] >= last - ENDS_SECONDS]),
        "dropped": camera + before_painting + preview,
        "dropped_by_camera": camera,
        "dropped_before_painting": before_painting,
        "dropped_in_preview": preview,
        "ways_ms": _ways(counted, due, seen),
        **_process(samples, began, last, len(counted)),
        "viewer_cpu_ms_per_frame": 1000 * float(viewed[-1, 1]) / max(len(viewed) - 1, 1),
    }


def _seen(frames: np.ndarray, viewed_at: dict[float, float]) -> np.ndarray:
    """(N,) monotonic seconds at which the viewer had each frame; NaN: never."""
    return np.array([viewed_at.get(pts, math.nan) for pts in frames[:, 0]])


def _latency_ms(frames: np.ndarray, viewed_at: dict[float, float]) -> np.ndarray:
    return 1000 * _seen(frames, viewed_at) - frames[:, 0] / 1000


def _ways(counted: np.ndarray, due: np.ndarray, seen: np.ndarray) -> dict[str, dict[str, float]]:
    """Where the time goes from arrival to viewer, in ms: each stage, and the ways in between."""

    def column(name: str) -> np.ndarray:
        return _column(counted, name)

    ways = {"arrival to work": column("work begins") - due}
    ways |= {name: column(f"{name} ends") - column(f"{name} begins") for name in _STAGES[1:-1]}
    ways |= {
        "all work": column("work ends") - column("work begins"),
        "to the preview": column("preview begins") - column("work ends"),
        "preview": column("preview ends") - column("preview begins"),
        "to the viewer": seen - column("preview ends"),
    }
    return {name: _spread(1000 * taken) for name, taken in ways.items()}


def _column(table: np.ndarray, name: str) -> np.ndarray:
    column: np.ndarray = table[:, COLUMNS.index(name)]
    return column


def _spread(ms: np.ndarray) -> dict[str, float]:
    known = ms[~np.isnan(ms)]
    if not known.size:
        return {}
    p50, p95, p99 = np.percentile(known, (50, 95, 99)).tolist()
    return {"p50": p50, "p95": p95, "p99": p99, "max": float(known.max())}


def _process(samples: np.ndarray, began: float, last: float, frames: int) -> dict[str, Any]:
    """CPU time and memory of the live process. The viewer and making the video do not count."""
    seconds, memory_mb, cpu = samples.T
    first, end = np.interp((began, last), seconds, cpu)
    early, late = np.interp((min(began + ENDS_SECONDS, last), last), seconds, memory_mb)
    return {
        "cpu_ms_per_frame": 1000 * float(end - first) / frames,
        "cpu_cores": float((end - first) / (last - began)),
        "memory_mb": {"after_10_s": _known(early), "at_end": _known(late)},
    }


def _known(number: float) -> float | None:
    return None if math.isnan(number) else float(number)
