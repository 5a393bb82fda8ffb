"""Print the table of docs/scale.md: CPU time of a video in one run, and in segments.

python docs/make/measure_split.py [--seconds 20] [--rounds 2]
"""

import argparse
import resource
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from statistics import median

from makeup_video.benchmark.renderer import full_look
from makeup_video.benchmark.videos import X264_OPTIONS, make_video, pictures, write_video
from makeup_video.pipeline import Look, Settings, process_video
from makeup_video.pipeline.media import join

SAMPLE = Path(__file__).parents[2] / "samples" / "in.mp4"
HEIGHT_PX, RATE = 720, 30
LENGTHS = (None, 10, 5)  # s of a segment; None: one run


def cpu_seconds() -> float:
    """CPU time of this process and of all child processes that have ended, start included."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


class TimedJoin(join.Join):
    """Adds up the CPU seconds of joining."""

    seconds = 0.0

    def finish(self, files: Iterable[join.SegmentFile]) -> None:
        began = time.process_time()
        super().finish(list(files))
        TimedJoin.seconds += time.process_time() - began


def measure(video: Path, folder: Path, look: Look, length: int | None) -> tuple[int, float, float]:
    """(segments, CPU seconds in all, CPU seconds of joining) of one run."""
    minutes = None if length is None else Fraction(length, 60)
    began, TimedJoin.seconds = cpu_seconds(), 0.0
    settings = Settings(split_minutes=minutes, overwrite=True)
    report = process_video(video, folder / "out.mp4", look, settings)
    return report.segments, cpu_seconds() - began, TimedJoin.seconds


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seconds", type=int, default=20)
    options.add_argument("--rounds", type=int, default=2)
    chosen = options.parse_args()
    from makeup_video.pipeline.offline import split

    split.Join = TimedJoin
    runs = defaultdict(list)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made = make_video(SAMPLE, folder / "made.mp4", HEIGHT_PX, chosen.seconds * RATE)
        print(f"{made.description}, {chosen.rounds} rounds")
        video = folder / "in.mp4"
        write_video(video, pictures(made.path), {**X264_OPTIONS, "g": str(2 * RATE)})
        measure(video, folder, full_look(), None)  # compiles the kernels
        for _ in range(chosen.rounds):
            for length in LENGTHS:
                runs[length].append(measure(video, folder, full_look(), length))
                print(length, runs[length][-1], flush=True)
    whole = median(cpu for _, cpu, _ in runs[None])
    print("| segment | segments | CPU s | more than one run | a seam, CPU s | joining, CPU s |")
    print("|---|---|---|---|---|---|")
    for length, measured in runs.items():
        segments = measured[0][0]
        cpu, joining = (median(run[column] for run in measured) for column in (1, 2))
        seams = f"{(cpu - whole) / (segments - 1):.2f}" if segments > 1 else ""
        print(
            f"| {f'{length} s' if length else 'one run'} | {segments} | {cpu:.1f} "
            f"| {100 * (cpu / whole - 1):.1f} % | {seams} | {joining:.2f} |"
        )


if __name__ == "__main__":
    main()
