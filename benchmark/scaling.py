"""How the cost grows: with faces, with threads, with the length of the film."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any
from unittest.mock import patch

from makeup_video.benchmark.films import RATE, Clip, first_frames, repeat_film, tile
from makeup_video.benchmark.harness import BARE_THREADS, Bench, beside, in_turn, middle, own_threads
from makeup_video.benchmark.runs import Run, run_bare, run_command, run_product
from makeup_video.pipeline import UsageError
from makeup_video.pipeline.engine.runner import Runner
from makeup_video.pipeline.media.decode import Decoder
from makeup_video.pipeline.media.encode import VideoEncoder
from makeup_video.pipeline.offline import run as process

# of decoder, encoder (0 as above) and stages; the first is what the product chooses on two cores
SHARED = ((1, 0, 1), (1, 0, 2), (1, 0, 4), (1, 1, 1), (1, 2, 1), (2, 0, 1), (0, 0, 4))
_POCL_THREADS = (1, 2)
FACES, _GRID = (1, 2, 4, 8), (4, 2)
_FEW_ROUNDS = 3  # where one number of several is a median
_MEMORY_SAMPLES = 400


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
        done = run_command(
            short, target, bench.worn, environment=environment, stderr=bench.child_stderr
        )
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
    done = run_command(
        film,
        bench.folder / "long-ours.mp4",
        bench.worn,
        sample_seconds=every,
        stderr=bench.child_stderr,
    )
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
