"""The measurements behind `makeup-video bench`: each compares runs in turn and returns plain numbers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

from makeup_video.cli.measure_clip import RATE, Clip, first_frames, make_clip, repeat_film, tile
from makeup_video.cli.measure_run import (
    Run,
    first_time,
    run_bare,
    run_command,
    run_product,
)
from makeup_video.cli.measure_stages import Observed, bottleneck, fills
from makeup_video.pipeline import Look, Report, Settings, UsageError, process, process_video
from makeup_video.pipeline.decode import Decoder
from makeup_video.pipeline.encode import VideoEncoder
from makeup_video.pipeline.runner import Runner

# (decoder threads, encoder threads), 0 = FFmpeg's own choice: the bare loop may have the best
BARE_THREADS = ((0, 0), (1, 2), (2, 3), (2, 4))
# of decoder, encoder (0 as above) and stages; the first is what the product chooses on two cores
SHARED = ((1, 0, 1), (1, 0, 2), (1, 0, 4), (1, 1, 1), (1, 2, 1), (2, 0, 1), (0, 0, 4))
_POCL_THREADS = (1, 2)
_CHOOSING = 150  # frames, while the best threads are looked for
_DEFAULT_RUNS = 2  # with the default preset and quality: they only tell times real time
FACES, _GRID = (1, 2, 4, 8), (4, 2)
_START_SECONDS, _STARTS = 2, 3
_FEW_ROUNDS = 3  # where one number of several is a median
_MEMORY_SAMPLES = 400


@dataclass(slots=True)
class Bench:
    """What is measured with. told: hears what is done now.

    look: what is painted.  photo: what it was read from, if it was: the command that is measured in
    its own process then reads it too.  worn: that command's options.
    """

    source: Path
    folder: Path
    look: Look
    seconds: float
    rounds: int
    as_is: bool = False
    told: Callable[[str], None] = lambda text: None
    photo: Path | None = None
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


def compare(bench: Bench, clip: Clip, name: str) -> dict[str, Any]:
    """Bare loops, `--look none` and the whole product in turn (A B C D, B C D A, ...).

    bare: the loop with its best threads, which is the limit.  codec: with the product's own, so that the CPU
    time that the product takes more is all that is not codec.
    Ratios are those of medians; their spread is that of the rounds, and tells how quiet the machine was.
    """
    bare_file, our_file = bench.folder / "bare.mp4", bench.folder / "ours.mp4"
    bench.told(f"{name}: the bare loop's best threads")
    by_threads = _bare_by_threads(bench, clip)
    best = max(by_threads, key=lambda threads: by_threads[threads])
    # what is loaded and compiled once is told apart: see own_process
    run_product(bench.folder / "short.mp4", our_file, bench.look)
    observed, reports = Observed(), []

    def whole() -> Run:
        observed.start()
        run, report = run_product(clip.path, our_file, bench.look, observe=observed)
        reports.append(report)
        return run

    runs = in_turn(
        bench,
        name,
        {
            "bare": lambda: run_bare(clip.path, bare_file, best),
            "codec": lambda: run_bare(clip.path, bare_file, own_threads()),
            "none": lambda: run_product(clip.path, our_file, None)[0],
            "product": whole,
        },
        bench.rounds,
    )
    bench.told(f"{name}: the default preset")
    times = [_times_real_time(bench, clip) for _ in range(min(_DEFAULT_RUNS, bench.rounds))]
    stages, channels = observed.table(clip.frames), fills(report.channels for report in reports)
    return {
        "film": clip.told,
        "bare": {**middle(runs["bare"]), "threads": list(best)},
        "bare_by_threads": {f"{a}+{b}": fps for (a, b), fps in by_threads.items()},
        "codec": {**middle(runs["codec"]), "threads": list(own_threads())},
        "none": {**middle(runs["none"]), **beside(runs["none"], runs["bare"], runs["codec"])},
        "product": {
            **middle(runs["product"]),
            **beside(runs["product"], runs["bare"], runs["codec"]),
        },
        "painted_share": min(_painted(report) for report in reports),
        "default_times_real_time": median(times),
        "stages": stages,
        "channels": channels,
        "bottleneck": bottleneck(channels, stages),
    }


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


def _painted(report: Report) -> float:
    return (report.painted_frames or 0) / report.frames_out


def _times_real_time(bench: Bench, clip: Clip) -> float:
    settings = Settings(overwrite=True)
    report = process_video(clip.path, bench.folder / "default.mp4", bench.look, settings)
    return report.frames_per_second / RATE


def _bare_by_threads(bench: Bench, clip: Clip) -> dict[tuple[int, int], float]:
    """Frames/s of the bare loop by its threads; two passes over all, the better one counts."""
    short, target = bench.folder / "short.mp4", bench.folder / "bare.mp4"
    first_frames(clip.path, short, _CHOOSING)
    run_bare(short, target, BARE_THREADS[0])  # warms the file cache, not counted
    passes = [{t: run_bare(short, target, t).fps for t in BARE_THREADS} for _ in range(2)]
    return {threads: max(done[threads] for done in passes) for threads in BARE_THREADS}


def own_process(bench: Bench, clip: Clip, name: str) -> dict[str, float]:
    """What only the real command in its own process shows: peak memory, and how long it takes to start.

    first: where our kernels were never compiled; warm: the median of some later starts.
    """
    bench.told(f"{name}: start and memory")
    target = bench.folder / "own.mp4"
    short = ("--end", str(_START_SECONDS))

    def start(environment: dict[str, str]) -> float:
        done = run_command(clip.path, target, bench.worn, words=short, environment=environment)
        return float(done["start_seconds"])

    with TemporaryDirectory(dir=bench.folder) as caches:
        kept = first_time(Path(caches))
        first, *warm = [start(kept) for _ in range(1 + _STARTS)]
    whole = run_command(clip.path, target, bench.worn)
    return {
        "first_start_seconds": first,
        "start_seconds": median(warm),
        "peak_memory_mb": whole["peak_memory_bytes"] / 1e6,
    }


def by_faces(bench: Bench, height_px: int) -> dict[str, Any]:
    """The same frame with 1, 2, 4 and 8 of its tiles showing a face, each half its tile's height."""
    columns, rows = _GRID
    height, width = height_px // rows // 2 * 2, height_px * 16 // 9 // columns // 2 * 2
    one = bench.clip(height, bench.seconds / 2, width_px=width)
    if one.faces > 1:
        raise UsageError(f"--faces needs a clip of one face, {bench.source} shows {one.faces}")
    films = {count: bench.folder / f"faces{count}.mp4" for count in FACES}
    for count, film in films.items():
        tile(one.path, film, count, _GRID)
    target, table = bench.folder / "bare.mp4", {}
    for count, film in films.items():
        work = {
            "bare": partial(run_bare, film, target, own_threads()),
            "product": partial(_painted_run, bench, film),
        }
        runs = in_turn(bench, f"{count} faces", work, min(bench.rounds, _FEW_ROUNDS))
        table[str(count)] = {
            **middle(runs["product"]),
            **beside(runs["product"], runs["bare"]),
        }
    least, most = table[str(FACES[0])], table[str(FACES[-1])]
    more = most["not_codec_cpu_ms"] - least["not_codec_cpu_ms"]
    return {
        "height_px": height_px,
        "counts": table,
        "further_face_cpu_ms": more / (FACES[-1] - FACES[0]),
    }


def by_threads(bench: Bench, clip: Clip, name: str) -> dict[str, Any]:
    """Frames/s by the threads of the codecs and of the stages, and by those of PoCL, in turn."""
    short = bench.folder / "threads.mp4"
    first_frames(clip.path, short, clip.frames // 2)
    target = bench.folder / "ours.mp4"

    def own(threads: int) -> Run:
        """PoCL asks when it is loaded: so each in a process of its own."""
        environment = {"POCL_MAX_PTHREAD_COUNT": str(threads)}
        done = run_command(short, target, bench.worn, environment=environment)
        return Run(done["frames_out"], done["seconds"], done["cpu_seconds"])

    work: dict[str, Callable[[], Run]] = {}
    for pair in BARE_THREADS:
        work[f"bare: {_codecs(*pair)}"] = partial(run_bare, short, target, pair)
    for decoder, encoder, workers in SHARED:
        told = f"product: {_codecs(decoder, encoder)}, stages {workers}"
        work[told] = partial(_run_shared, bench, short, decoder, encoder, workers)
    for count in _POCL_THREADS:
        work[f"command: PoCL {count}"] = partial(own, count)
    runs = in_turn(bench, name, work, min(bench.rounds, _FEW_ROUNDS))
    table = {one: middle(done) for one, done in runs.items()}
    ours = {one: row["fps"] for one, row in table.items() if one.startswith("product")}
    return {"settings": table, "best": max(ours, key=lambda one: ours[one])}


def _painted_run(bench: Bench, film: Path) -> Run:
    return run_product(film, bench.folder / "ours.mp4", bench.look)[0]


def _run_shared(bench: Bench, film: Path, decoder: int, encoder: int, workers: int) -> Run:
    """The product with other threads than it chooses."""

    def decoder_of(*given: Any, **named: Any) -> Decoder:
        return Decoder(*given, **{**named, "threads": decoder})

    def encoder_of(muxer: Any, source: Any, codec: Any, options: Any, _: int) -> VideoEncoder:
        return VideoEncoder(muxer, source, codec, options, encoder)

    with (
        patch.object(process, "Decoder", decoder_of),
        patch.object(process, "VideoEncoder", encoder_of),
        patch.object(process, "Runner", partial(Runner, workers=workers)),
    ):
        return _painted_run(bench, film)


def _codecs(decoder: int, encoder: int) -> str:
    return f"decoder {decoder or 'auto'}, encoder {encoder or 'auto'}"


def over_length(bench: Bench, height_px: int, minutes: float) -> dict[str, Any]:
    """The real command on a film of so many minutes: its speed, and its memory as it goes.

    memory: [[seconds, MB], ...].  growth: memory in its last tenth by that in its third tenth.
    """
    one = bench.clip(height_px, loops=True)
    times = max(1, round(minutes * 60 * RATE / one.frames))
    film = repeat_film(one.path, bench.folder / "long.mp4", times)
    bench.told(f"{height_px}p: {times * one.frames / RATE / 60:.1f} minutes of film")
    every = max(0.1, minutes * 60 / 5 / _MEMORY_SAMPLES)
    done = run_command(film, bench.folder / "long-ours.mp4", bench.worn, sample_seconds=every)
    tenth = max(1, len(done["memory"]) // 10)
    sizes = [size_mb for _, size_mb in done["memory"]] or [0.0]
    return {
        "minutes": times * one.frames / RATE / 60,
        "frames": done["frames_out"],
        "fps": done["fps"],
        "peak_memory_mb": done["peak_memory_bytes"] / 1e6,
        "growth": median(sizes[-tenth:]) / max(median(sizes[2 * tenth : 3 * tenth] or sizes), 1e-9),
        "memory": [[round(at, 2), round(size_mb, 1)] for at, size_mb in done["memory"]],
    }
