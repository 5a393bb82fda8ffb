"""Measures what frames in memory cost: the table of docs/python.md.

    python docs/make/measure_frames.py [VIDEO] [ROUNDS]

Prints the CPU time of all threads of this process, in ms a frame. The ways to paint are measured
in turn.
"""

import argparse
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from statistics import median

import av
import numpy as np
from makeup_video import Painter, Settings, apply_look, paint_frames, process_video, ready_look
from makeup_video.pipeline.frames.rgb_frame import RgbFrame
from makeup_video.pipeline.smoothing.lookahead import AHEAD_FRAMES

_FRAMES, _ALONE, _FIRST = 120, 20, 10  # frames; those for apply_look; those left out at the start
_STAGES = ("faces", "smooth", "scene", "composite")


def cpu_ms(painted: Iterator[object]) -> float:
    """Mean CPU ms of an item, without the first and the last ones.

    paint_frames reads AHEAD_FRAMES ahead, so its last items cost little more than painting.
    """
    for _ in range(_FIRST):
        next(painted)
    began, times = time.process_time(), []
    for _ in painted:
        times.append(time.process_time() - began)
    return 1000 * times[-1 - AHEAD_FRAMES] / (len(times) - AHEAD_FRAMES)


def stages_ms(video: str, look: object) -> float:
    """CPU ms a frame of the stages of process_video that do the work of paint_frames."""
    cost: dict[str, list[float]] = defaultdict(list)
    settings = Settings(observe=lambda name, wall, cpu: cost[name].append(cpu), overwrite=True)
    with tempfile.TemporaryDirectory() as folder:
        process_video(video, Path(folder) / "out.mp4", look, settings)
    return 1000 * sum(float(np.mean(cost[name][_FIRST:])) for name in _STAGES)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("video", metavar="VIDEO", nargs="?", default="samples/in.mp4")
    parser.add_argument("rounds", metavar="ROUNDS", nargs="?", type=int, default=3)
    options = parser.parse_args()
    video = options.video
    look = ready_look("smoky-brown").look
    with av.open(video) as source:
        decoded = zip(source.decode(video=0), range(_FRAMES), strict=False)
        frames = [frame.to_ndarray(format="rgb24") for frame, _ in decoded]
    found = defaultdict(list)
    for _ in range(options.rounds):
        painter = Painter(look)
        found["stages of process_video"].append(stages_ms(video, look))
        found["paint_frames"].append(cpu_ms(paint_frames(frames, look)))
        found["Painter"].append(cpu_ms(painter(one, at / 30) for at, one in enumerate(frames)))
        found["conversion"].append(cpu_ms(RgbFrame(one, 0).painted() for one in frames))
        alone = frames[: _FIRST + _ALONE]
        found["apply_look"].append(cpu_ms(apply_look(one, look) for one in alone))
    for name, values in found.items():
        print(f"{name}: {median(values):.1f} ms ({min(values):.1f} to {max(values):.1f})")


if __name__ == "__main__":
    main()
