"""Measure the savings and errors of each quality level of a live run, for docs/live.md.

    python docs/make/measure_levels.py samples/in.mp4 talk.mp4

All levels run in turn on every frame, in one thread, without a codec. The script prints a Markdown
table with the CPU time of the stages and the differences from level 0: of the smoothed lips and
eyes, and of the painted picture.
"""

import argparse
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from makeup_video.benchmark.renderer import full_look
from makeup_video.benchmark.videos import frame_of, make_video, pictures
from makeup_video.pipeline.engine.quality import QualityLevel
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.faces.topology import EYE, EYE_CORNERS, LIPS, RIGHT_EYE
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.smoothing.realtime import SmoothLive

WARM_UP = 15  # frames that are not counted
STAGES = "faces", "smooth", "scene", "paint"
PARTS = np.concatenate([LIPS, EYE, RIGHT_EYE])


@dataclass
class Level:
    """The stages at one quality level, with their CPU times and errors."""

    number: int
    milliseconds: list[list[float]] = field(default_factory=list)  # by frame and stage
    points_off: list[float] = field(
        default_factory=list
    )  # thousandths of the distance between the eyes
    codes_off: list[float] = field(default_factory=list)  # of luma, where level 0 paints

    def __post_init__(self) -> None:
        self.find, self.smooth, self.scene = FindFaces(), SmoothLive(), BuildScene()
        self.paint = Composite(full_look())
        self.find.level = self.paint.level = self.number

    def __call__(self, frame: Frame) -> tuple[FrameFaces, np.ndarray]:
        """Process a frame and return the smoothed faces and the painted luma."""
        frame.writable_planes()  # a camera's planes are writable, too
        times = [time.process_time()]
        found = self.find(frame)
        times.append(time.process_time())
        faces = self.smooth(found)
        times.append(time.process_time())
        scene = self.scene(faces)
        times.append(time.process_time())
        painted = self.paint(scene)
        times.append(time.process_time())
        self.milliseconds.append((1000 * np.diff(times)).tolist())
        return faces, painted.planes[0]

    def compare(self, mine: "Shown", whole: "Shown", bare: np.ndarray) -> None:
        """Add the errors of a result to the lists.

        mine: the result of this level.  whole: that of level 0.  bare: the luma before painting.
        """
        for face, true in zip(mine[0].faces, whole[0].faces, strict=False):
            xy = true.points_px[:, :2]
            unit = np.linalg.norm(np.subtract(*xy[list(EYE_CORNERS)]))
            off = np.linalg.norm((face.points_px[:, :2] - xy)[PARTS], axis=1).mean()
            self.points_off.append(float(1000 * off / unit))
        is_painted = whole[1] != bare
        if is_painted.any():
            difference = cv2.absdiff(mine[1], whole[1])[is_painted]
            self.codes_off.append(float(difference.mean()) / 2 ** (8 * (bare.itemsize - 1)))


Shown = tuple[FrameFaces, np.ndarray]


def measure(video: Path) -> list[Level]:
    """Run all levels on a video, frame by frame, and return them with their results."""
    levels = [Level(number) for number in QualityLevel]
    streams = (pictures(video) for _ in range(len(levels) + 1))
    for number, pictures_now in enumerate(zip(*streams, strict=True)):
        bare, *frames = map(frame_of, pictures_now)
        # The first level of a frame pays for cold caches, so the levels take turns.
        first = number % len(levels)
        order = levels[first:] + levels[:first]
        shown = {level.number: level(frames[level.number]) for level in order}
        for level in levels:
            level.compare(shown[level.number], shown[0], bare.planes[0])
    return levels


def rows(name: str, height_px: int, levels: list[Level]) -> Iterator[str]:
    """Yield a row of the Markdown table for each level."""
    for level in levels:
        spent = np.array(level.milliseconds)[WARM_UP:]
        stages = " | ".join(f"{stage_ms:.2f}" for stage_ms in spent.mean(0))
        total = spent.sum(1)
        off, codes = np.array(level.points_off or [0.0]), np.array(level.codes_off or [0.0])
        yield (
            f"| {name}, {height_px}p | {level.number} | {stages} | {total.mean():.2f} | "
            f"{np.percentile(total, 95):.2f} | {off.mean():.1f} | {np.percentile(off, 95):.1f} | "
            f"{codes.mean():.2f} |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("clips", nargs="+", type=Path)
    parser.add_argument("--heights", default="720,1080,2160")
    parser.add_argument("--frames", type=int, default=90)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    heads = ["clip", "level", *STAGES, "all", "95th", "points off", "95th", "codes off"]
    print("| " + " | ".join(heads) + " |\n|" + "---|" * len(heads))
    with tempfile.TemporaryDirectory() as folder:
        for clip in options.clips:
            for height_px in map(int, options.heights.split(",")):
                target = Path(folder) / f"{clip.stem}_{height_px}.mp4"
                video = make_video(clip, target, height_px, options.frames, as_is=True).path
                for row in rows(clip.name, height_px, measure(video)):
                    print(row, flush=True)


if __name__ == "__main__":
    main()
