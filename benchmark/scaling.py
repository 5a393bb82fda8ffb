"""How the cost grows with faces, with threads and with the length of the video."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from makeup_video.benchmark.harness import BARE_THREADS, Bench, beside, in_turn, middle, own_threads
from makeup_video.benchmark.runs import SETTINGS, Run, run_bare, run_command, run_product
from makeup_video.benchmark.videos import RATE, Video, first_frames, repeat_video, tile
from makeup_video.pipeline.errors import UsageError, option

# Threads of (decoder, encoder, stages); 0: FFmpeg's own choice. On two cores the product itself
# chooses the first row.
SHARED = ((1, 0, 1), (1, 0, 2), (1, 0, 4), (1, 1, 1), (1, 2, 1), (2, 0, 1), (0, 0, 4))
_POCL_THREADS = (0, 1, 2)
FACES, _GRID = (1, 2, 4, 8), (4, 2)
_FEW_ROUNDS = 3  # enough for one row of a table
_MEMORY_SAMPLES = 400


def by_faces(bench: Bench, height_px: int) -> dict[str, Any]:
    """The cost by number of faces: 1, 2, 4 or 8 tiles of a frame show a face of half their height.

    Raises UsageError for a clip of several faces.
    """
    columns, rows = _GRID
    height, width = height_px // rows // 2 * 2, height_px * 16 // 9 // columns // 2 * 2
    made = bench.video(height, bench.seconds / 2, width_px=width)
    if made.faces > 1:
        raise UsageError(
            f"{option('faces')} needs a clip of one face, {bench.source} shows {made.faces}"
        )
    videos = {count: bench.folder / f"faces{count}.mp4" for count in FACES}
    for count, video in videos.items():
        tile(made.path, video, count, _GRID)
    target, table = bench.folder / "bare.mp4", {}
    for count, video in videos.items():
        work = {
            "bare": partial(run_bare, video, target, own_threads()),
            "product": partial(_painted_run, bench, video),
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


def by_threads(bench: Bench, video: Video, name: str) -> dict[str, Any]:
    """Frames/s by the threads of the codecs and the stages, and by the threads of PoCL."""
    short = bench.folder / "threads.mp4"
    first_frames(video.path, short, video.frames // 2)
    target = bench.folder / "ours.mp4"

    def with_pocl_threads(threads: int) -> Run:
        """Run the command in a process of its own, since PoCL reads the variables when it loads.

        threads: 0: the device that the product takes, which paints in the stage's own thread.
        """
        environment = {"POCL_DEVICES": "pthread", "POCL_MAX_PTHREAD_COUNT": str(threads)}
        if not threads:
            environment = {}
        values = run_command(
            short, target, bench.look_words, environment=environment, stderr=bench.child_stderr
        )
        return Run(values["frames_out"], values["seconds"], values["cpu_seconds"])

    work: dict[str, Callable[[], Run]] = {}
    for pair in BARE_THREADS:
        work[f"bare: {_codecs(*pair)}"] = partial(run_bare, short, target, pair)
    for decoder, encoder, stages in SHARED:
        label = f"product: {_codecs(decoder, encoder)}, stages {stages}"
        work[label] = partial(_run_with_threads, bench, short, decoder, encoder, stages)
    for count in _POCL_THREADS:
        work[f"command: PoCL {count or 'as usual'}"] = partial(with_pocl_threads, count)
    runs = in_turn(bench, name, work, min(bench.rounds, _FEW_ROUNDS))
    table = {label: middle(rounds) for label, rounds in runs.items()}
    ours = {label: row["fps"] for label, row in table.items() if label.startswith("product")}
    return {"settings": table, "best": max(ours, key=lambda label: ours[label])}


def _painted_run(bench: Bench, video: Path) -> Run:
    return run_product(video, bench.folder / "ours.mp4", bench.look)[0]


def _run_with_threads(bench: Bench, video: Path, decoder: int, encoder: int, stages: int) -> Run:
    """Run the product with these numbers of threads, not its own; 0: FFmpeg chooses."""
    settings = replace(
        SETTINGS, decoder_threads=decoder, encoder_threads=encoder, stage_threads=stages
    )
    return run_product(video, bench.folder / "ours.mp4", bench.look, settings)[0]


def _codecs(decoder: int, encoder: int) -> str:
    return f"decoder {decoder or 'auto'}, encoder {encoder or 'auto'}"


def over_length(bench: Bench, height_px: int, minutes: float) -> dict[str, Any]:
    """Run the real command on a video of this length: its speed, and its memory over time.

    memory: [[seconds, MB], ...].  growth: median memory in the last tenth of the run, divided by
    that in the third tenth.
    """
    made = bench.video(height_px, loops=True)
    times = max(1, round(minutes * 60 * RATE / made.frames))
    video = repeat_video(made.path, bench.folder / "long.mp4", times)
    bench.log(f"{height_px}p: {times * made.frames / RATE / 60:.1f} minutes of video")
    every = max(0.1, minutes * 60 / 5 / _MEMORY_SAMPLES)
    values = run_command(
        video,
        bench.folder / "long-ours.mp4",
        bench.look_words,
        sample_seconds=every,
        stderr=bench.child_stderr,
    )
    tenth = max(1, len(values["memory"]) // 10)
    sizes = [size_mb for _, size_mb in values["memory"]] or [0.0]
    return {
        "minutes": times * made.frames / RATE / 60,
        "frames": values["frames_out"],
        "fps": values["fps"],
        "peak_memory_mb": values["peak_memory_bytes"] / 1e6,
        "growth": median(sizes[-tenth:]) / max(median(sizes[2 * tenth : 3 * tenth] or sizes), 1e-9),
        "memory": [[round(seconds, 2), round(size_mb, 1)] for seconds, size_mb in values["memory"]],
    }
