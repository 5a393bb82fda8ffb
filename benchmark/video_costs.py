"""The cost of a video by the bare codec, --look none and the whole product; start and memory."""

from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

from makeup_video.benchmark.harness import BARE_THREADS, Bench, beside, in_turn, middle, own_threads
from makeup_video.benchmark.runs import Run, empty_caches, run_bare, run_command, run_product
from makeup_video.benchmark.stages import StageLog, bottleneck, fills
from makeup_video.benchmark.videos import RATE, Video, first_frames
from makeup_video.pipeline import Report, Settings, process_video

_CHOOSING = 150  # frames on which the bare loop's threads are compared
_DEFAULT_RUNS = 2  # with the default preset and quality, only to compare with real time
_START_SECONDS, _STARTS = 2, 3


def compare(bench: Bench, video: Video, name: str) -> dict[str, Any]:
    """Run bare loops, `--look none` and the whole product in turn (A B C D, B C D A, ...).

    bare: the loop with its best threads, which is the limit.  codec: the loop with the product's
    threads; CPU time of the product beyond this loop is not the codec's.
    Each ratio is one of medians; its spread is that of the rounds, wider on a busy machine.
    """
    bare_file, our_file = bench.folder / "bare.mp4", bench.folder / "ours.mp4"
    bench.log(f"{name}: the bare loop's best threads")
    by_threads = _bare_by_threads(bench, video)
    best = max(by_threads, key=lambda threads: by_threads[threads])
    # loads and compiles what is needed only once; own_process measures the time for that
    run_product(bench.folder / "short.mp4", our_file, bench.look)
    observed, reports = StageLog(), []

    def whole() -> Run:
        observed.start()
        run, report = run_product(video.path, our_file, bench.look, observe=observed)
        reports.append(report)
        return run

    runs = in_turn(
        bench,
        name,
        {
            "bare": lambda: run_bare(video.path, bare_file, best),
            "codec": lambda: run_bare(video.path, bare_file, own_threads(video)),
            "none": lambda: run_product(video.path, our_file, None)[0],
            "product": whole,
        },
        bench.rounds,
    )
    bench.log(f"{name}: the default preset")
    times = [_times_real_time(bench, video) for _ in range(min(_DEFAULT_RUNS, bench.rounds))]
    stages, channels = observed.table(video.frames), fills(report.channels for report in reports)
    return {
        "film": video.description,
        "bare": {**middle(runs["bare"]), "threads": list(best)},
        "bare_by_threads": {f"{a}+{b}": fps for (a, b), fps in by_threads.items()},
        "codec": {**middle(runs["codec"]), "threads": list(own_threads(video))},
        "none": {**middle(runs["none"]), **beside(runs["none"], runs["bare"], runs["codec"])},
        "product": {
            **middle(runs["product"]),
            **beside(runs["product"], runs["bare"], runs["codec"]),
        },
        "painted_share": min(_painted_share(report) for report in reports),
        "default_times_real_time": median(times),
        "stages": stages,
        "channels": channels,
        "bottleneck": bottleneck(channels, stages),
    }


def _painted_share(report: Report) -> float:
    return (report.painted_frames or 0) / report.frames_out


def _times_real_time(bench: Bench, video: Video) -> float:
    settings = Settings(overwrite=True)
    report = process_video(video.path, bench.folder / "default.mp4", bench.look, settings)
    return report.frames_per_second / RATE


def _bare_by_threads(bench: Bench, video: Video) -> dict[tuple[int, int], float]:
    """Frames/s of the bare loop by its threads, from the better of two passes."""
    short, target = bench.folder / "short.mp4", bench.folder / "bare.mp4"
    first_frames(video.path, short, _CHOOSING)
    run_bare(short, target, BARE_THREADS[0])  # warms the file cache, not counted
    passes = [{t: run_bare(short, target, t).fps for t in BARE_THREADS} for _ in range(2)]
    return {threads: max(fps[threads] for fps in passes) for threads in BARE_THREADS}


def own_process(bench: Bench, video: Video, name: str) -> dict[str, float]:
    """Measure what only the real command in its own process shows: peak memory and start-up time.

    first_start_seconds: with empty kernel caches.  start_seconds: median of later starts.
    """
    bench.log(f"{name}: start and memory")
    target = bench.folder / "own.mp4"
    short = ("--end", str(_START_SECONDS))

    def start(environment: dict[str, str]) -> float:
        values = run_command(
            video.path,
            target,
            bench.look_words,
            words=short,
            environment=environment,
            stderr=bench.child_stderr,
        )
        return float(values["start_seconds"])

    start({})  # compiles the modules, and fills the system's file cache
    with TemporaryDirectory(dir=bench.folder) as caches:
        environment = empty_caches(Path(caches))
        first, *warm = [start(environment) for _ in range(1 + _STARTS)]
    whole = run_command(video.path, target, bench.look_words, stderr=bench.child_stderr)
    return {
        "first_start_seconds": first,
        "start_seconds": median(warm),
        "peak_memory_mb": whole["peak_memory_bytes"] / 1e6,
    }
