"""What each further look of one video costs, compared with a run of its own."""

import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from makeup_video.benchmark.harness import Bench, in_turn, middle
from makeup_video.benchmark.runs import (
    SETTINGS,
    Run,
    check_painted,
    run_command,
    run_product,
    time_run,
)
from makeup_video.benchmark.videos import Video, frame_of, pictures
from makeup_video.pipeline import MakeupVideoError, process_looks
from makeup_video.pipeline.engine.machine import one_opencv_thread
from makeup_video.pipeline.engine.runner import Runner
from makeup_video.pipeline.media.input_file import open_video
from makeup_video.pipeline.offline.stages import FaceRun
from makeup_video.pipeline.render.build_scene import BuildScene

_MOST_ROUNDS = 3  # enough for one row of a table


def by_looks(bench: Bench, video: Video, count: int) -> dict[str, Any]:
    """The cost of `count` looks of one video: in one run, and in runs of their own.

    runs: "shared" stops before painting and encoding, "one" is the whole product with one look.
    own_cpu_ms: CPU ms a frame to paint and encode one look: "one" less "shared".
    further_cpu_ms: what each further look adds to a run.  further_by_own: the ratio of these two.
    many_by_separate: the seconds of one run with all looks, divided by those of separate runs.
    memory_mb: see _memory.
    """
    targets = [bench.folder / f"look{number}.mp4" for number in range(count)]
    work: dict[str, Callable[[], Run]] = {
        "shared": partial(_shared, video.path),
        "one": lambda: run_product(video.path, targets[0], bench.look)[0],
        "many": partial(_many, bench, video.path, targets),
        "separate": partial(_separate, bench, video.path, targets),
    }
    runs = in_turn(bench, f"{count} looks", work, min(bench.rounds, _MOST_ROUNDS))
    own = [a.cpu_ms_per_frame - b.cpu_ms_per_frame
           for a, b in zip(runs["one"], runs["shared"], strict=True)]  # fmt: skip
    further = [(a.cpu_ms_per_frame - b.cpu_ms_per_frame) / (count - 1)
               for a, b in zip(runs["many"], runs["one"], strict=True)]  # fmt: skip
    seconds = {name: median(run.seconds for run in rounds) for name, rounds in runs.items()}
    return {
        "looks": count,
        "runs": {name: middle(rounds) for name, rounds in runs.items()},
        "seconds": seconds,
        "own_cpu_ms": median(own),
        "further_cpu_ms": median(further),
        "further_by_own": median(further) / median(own),
        "many_by_separate": seconds["many"] / seconds["separate"],
        "memory_mb": _memory(bench, video.path, targets),
    }


class _Nothing:
    """A sink that counts the items it gets and drops them."""

    def __init__(self) -> None:
        self.items = 0

    def __call__(self, item: object) -> None:
        self.items += 1

    def finish(self, stopped: bool) -> None:
        pass


def _shared(video: Path) -> Run:
    """Run what all looks share: decoding, finding faces, smoothing and building the scene."""

    def work() -> int:
        sink = _Nothing()
        with closing(open_video(video)) as source:
            stages = FaceRun(lambda: [("scene", BuildScene())], paints=False)(source)
        frames = (frame_of(picture) for picture in pictures(video))
        with one_opencv_thread():
            Runner(("decode", frames), stages, ("nothing", sink)).run()
        return sink.items

    return time_run(work)


def _many(bench: Bench, video: Path, targets: list[Path]) -> Run:
    def work() -> int:
        frames = 0
        done = process_looks(video, dict.fromkeys(targets, bench.look), SETTINGS)
        for report in done.values():
            if isinstance(report, MakeupVideoError):
                raise report
            check_painted(report.painted_frames, report.frames_out)
            frames = report.frames_out
        return frames

    return time_run(work)


def _separate(bench: Bench, video: Path, targets: list[Path]) -> Run:
    def work() -> int:
        frames = [run_product(video, target, bench.look)[0].frames for target in targets]
        return frames[0]

    return time_run(work)


def _memory(bench: Bench, video: Path, targets: list[Path]) -> dict[str, float]:
    """Peak memory in MB, each measured in a process of its own.

    one, many: the command with one look and with all looks.  further: what each further look adds.
    encoder: what a second encoder adds to a bare loop.
    """
    bench.log(f"{len(targets)} looks: memory")
    one, many = (_command(bench, video, len(some)) for some in (targets[:1], targets))
    once, twice = (_alone(video, bench.folder, count) for count in (1, 2))
    further = (many - one) / (len(targets) - 1)
    return {"one": one, "many": many, "further": further, "encoder": twice - once}


def _command(bench: Bench, video: Path, count: int) -> float:
    """The peak memory of the command with `count` looks, in MB."""
    target = bench.folder / "of-{look}.mp4"
    values = run_command(video, target, bench.look_words * count, stderr=bench.child_stderr)
    first = values["outputs"][0] if count > 1 else values
    return float(first["peak_memory_bytes"]) / 1e6


def _alone(video: Path, folder: Path, encoders: int) -> float:
    """The peak memory of a bare loop with this number of encoders, in MB."""
    words = [sys.executable, "-m", "makeup_video.benchmark.encoder_alone"]
    words += [str(video), str(folder), str(encoders)]
    done = subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True)
    return int(done.stdout) / 1e6
