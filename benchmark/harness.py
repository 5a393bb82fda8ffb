"""The measurements behind `makeup-video bench`: each compares runs in turn and returns plain numbers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

from makeup_video.benchmark.films import RATE, Clip, make_clip
from makeup_video.benchmark.runs import Run
from makeup_video.pipeline import Look, UsageError
from makeup_video.pipeline.offline import run as process

# (decoder threads, encoder threads), 0 = FFmpeg's own choice: the bare loop may have the best
BARE_THREADS = ((0, 0), (1, 2), (2, 3), (2, 4))


@dataclass(slots=True)
class Bench:
    """What is measured with. told: hears what is done now.

    look: what is painted.  photo: what it was read from, if it was: the command that is measured in
    its own process then reads it too.  child_stderr: a file descriptor for the errors of such
    processes, None for ours.  worn: that command's options.
    """

    source: Path
    folder: Path
    look: Look
    seconds: float
    rounds: int
    as_is: bool = False
    told: Callable[[str], None] = lambda text: None
    photo: Path | None = None
    child_stderr: int | None = None
    worn: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        if self.look.is_bare:
            raise UsageError("the look paints nothing: give one with lips or eyes to measure with")
        if self.photo is not None:
            self.worn = "--ref", str(self.photo)
        else:
            self.look.save(self.folder / "look.json")
            self.worn = "--look", str(self.folder / "look.json")

    def clip(self, height_px: int, seconds: float | None = None, **how: Any) -> Clip:
        """The film to measure with, at a height."""
        self.told(f"{height_px}p: making the film")
        frames = round((seconds or self.seconds) * RATE)
        target = self.folder / f"film{height_px}.mp4"
        return make_clip(self.source, target, height_px, frames, as_is=self.as_is, **how)


def in_turn(
    bench: Bench, name: str, work: Mapping[str, Callable[[], Run]], rounds: int
) -> dict[str, list[Run]]:
    """Each of them once a round, every round beginning with another."""
    runs: dict[str, list[Run]] = {one: [] for one in work}
    order = list(work)
    for number in range(rounds):
        first = number % len(order)
        for one in order[first:] + order[:first]:
            bench.told(f"{name}: round {number + 1} of {rounds}, {one}")
            runs[one].append(work[one]())
    return runs


def middle(runs: list[Run]) -> dict[str, Any]:
    """Medians, and the slowest and quickest of the runs."""
    fps = [run.fps for run in runs]
    return {
        "fps": median(fps),
        "fps_spread": [min(fps), max(fps)],
        "cpu_ms_per_frame": median(run.cpu_ms_per_frame for run in runs),
    }


def beside(runs: list[Run], bare: list[Run], codec: list[Run] | None = None) -> dict[str, Any]:
    """Ours by the bare loop's frames/s, and the CPU time that ours took more than the codec (None:
    the bare loop) in the same round."""
    ratios = [ours.fps / limit.fps for ours, limit in zip(runs, bare, strict=True)]
    return {
        "ratio": median(run.fps for run in runs) / median(run.fps for run in bare),
        "ratio_spread": [min(ratios), max(ratios)],
        "not_codec_cpu_ms": median(
            ours.cpu_ms_per_frame - codec_alone.cpu_ms_per_frame
            for ours, codec_alone in zip(runs, codec or bare, strict=True)
        ),
    }


def own_threads() -> tuple[int, int]:
    """Of decoder and encoder, as the product chooses them."""
    return process.decoder_threads(), 0
