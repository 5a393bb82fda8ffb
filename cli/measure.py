"""The measurements behind `makeup-video bench`: each returns plain numbers."""

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from statistics import median
from typing import Any

import av
from makeup_video.pipeline import InputError, Settings, process_video
from makeup_video.pipeline.source import local_file, open_video

CODEC, PRESET, CRF = "libx264", "veryfast", 20
_SETTINGS = Settings(codec="h264", preset=PRESET, crf=CRF, overwrite=True)
# (decoder threads, encoder threads), 0 = FFmpeg's own choice: the bare loop may have the best
BARE_THREADS = ((0, 0), (1, 2), (2, 3), (2, 4))


@dataclass(frozen=True, slots=True)
class Run:
    """One run over a clip: frames, wall seconds, CPU seconds of the whole process."""

    frames: int
    seconds: float
    cpu_seconds: float

    @property
    def fps(self) -> float:
        return self.frames / self.seconds

    @property
    def cpu_ms_per_frame(self) -> float:
        return 1000 * self.cpu_seconds / self.frames


def make_clip(source: Path, target: Path, height_px: int, seconds: float) -> Path:
    """`source` scaled to a height and repeated up to a length, as H.264 at 30 frames/s."""
    frames = round(seconds * 30)
    with av.open(str(target), "w") as out:
        stream: Any = None
        for index, picture in enumerate(_repeated(source, frames)):
            width = round(picture.width * height_px / picture.height / 2) * 2
            if stream is None:
                stream = out.add_stream(CODEC, rate=30, options={"preset": PRESET, "crf": str(CRF)})
                stream.width, stream.height, stream.pix_fmt = width, height_px, "yuv420p"
            scaled = picture.reformat(width=width, height=height_px, format="yuv420p")
            scaled.pts, scaled.time_base, scaled.pict_type = index, Fraction(1, 30), 0
            out.mux(stream.encode(scaled))
        out.mux(stream.encode(None))
    return target


def _repeated(source: Path, count: int) -> Iterator[av.VideoFrame]:
    done = 0
    while done < count:
        opened = open_video(local_file(source))
        before = done
        try:
            for picture in opened.container.decode(opened.video):
                yield picture
                done += 1
                if done == count:
                    return
        finally:
            opened.close()
        if done == before:
            raise InputError(f"{source} has no frame to measure with: give a clip that plays")


def run_bare(source: Path, target: Path, threads: tuple[int, int]) -> Run:
    """The limit: a plain loop of decoding and encoding, the same codec settings, no audio."""
    began, cpu = time.perf_counter(), time.process_time()
    frames = 0
    with av.open(str(source)) as box, av.open(str(target), "w") as out:
        video = box.streams.video[0]
        video.thread_type, video.thread_count = "AUTO", threads[0]
        options = {"preset": PRESET, "crf": str(CRF)}
        stream: Any = out.add_stream(CODEC, rate=video.average_rate, options=options)
        stream.width, stream.height, stream.pix_fmt = video.width, video.height, video.pix_fmt
        stream.codec_context.time_base = video.time_base
        stream.codec_context.thread_count, stream.codec_context.thread_type = threads[1], "AUTO"
        for picture in box.decode(video):
            picture.pict_type = 0
            out.mux(stream.encode(picture))
            frames += 1
        out.mux(stream.encode(None))
    return Run(frames, time.perf_counter() - began, time.process_time() - cpu)


def run_product(source: Path, target: Path) -> tuple[Run, dict[str, Any]]:
    """`--look none`: the whole pipeline, nothing painted. Also gives the report."""
    began, cpu = time.perf_counter(), time.process_time()
    report = process_video(source, target, None, _SETTINGS)
    run = Run(report.frames_out, time.perf_counter() - began, time.process_time() - cpu)
    return run, report.to_dict()


def compare(source: Path, folder: Path, rounds: int) -> dict[str, Any]:
    """Bare loop and product in turn (A B, B A, ...); the bare loop with its best threads.

    The ratio is that of the medians; its spread is that of the rounds, and tells how quiet the
    machine was.
    """
    by_threads = _bare_by_threads(source, folder / "bare.mp4")
    best = max(by_threads, key=lambda threads: by_threads[threads])
    pairs: list[tuple[Run, Run]] = []
    for number in range(rounds):
        if number % 2:
            product, report = run_product(source, folder / "none.mp4")
            bare = run_bare(source, folder / "bare.mp4", best)
        else:
            bare = run_bare(source, folder / "bare.mp4", best)
            product, report = run_product(source, folder / "none.mp4")
        pairs.append((bare, product))
    ratios = [product.fps / bare.fps for bare, product in pairs]
    limit, ours = _middle([bare for bare, _ in pairs]), _middle([ours for _, ours in pairs])
    return {
        "bare": {**limit, "threads": list(best)},
        "bare_by_threads": {f"{a}+{b}": fps for (a, b), fps in by_threads.items()},
        "none": ours,
        "ratio": ours["fps"] / limit["fps"],
        "ratio_spread": [min(ratios), max(ratios)],
        "stages": {name: _per_frame(times) for name, times in report["stages"].items()},
        "channels": report["channels"],
    }


def _bare_by_threads(source: Path, target: Path) -> dict[tuple[int, int], float]:
    """Frames/s of the bare loop by its threads; two passes over all, the better one counts."""
    run_bare(source, target, BARE_THREADS[0])  # warms the file cache, not counted
    passes = [{t: run_bare(source, target, t).fps for t in BARE_THREADS} for _ in range(2)]
    return {threads: max(done[threads] for done in passes) for threads in BARE_THREADS}


def _middle(runs: list[Run]) -> dict[str, float]:
    return {
        "fps": median(run.fps for run in runs),
        "cpu_ms_per_frame": median(run.cpu_ms_per_frame for run in runs),
    }


def _per_frame(times: dict[str, float]) -> dict[str, float]:
    count = max(1.0, times["items"])
    return {
        "busy_ms": 1000 * times["busy_seconds"] / count,
        "cpu_ms": 1000 * times["cpu_seconds"] / count,
    }


def run_command(source: Path, target: Path) -> dict[str, float]:
    """The real command in its own process: peak memory, and start to first packet written."""
    report = target.with_suffix(".json")
    words = [sys.executable, "-m", "makeup_video.cli", str(source), "--look", "none", "-q", "-y"]
    words += ["-o", str(target), "--report", str(report), "--codec", "h264"]
    words += ["--preset", PRESET, "--crf", str(CRF)]
    began = time.time()
    subprocess.run(words, check=True, stdin=subprocess.DEVNULL)
    values = json.loads(report.read_text(encoding="utf-8"))
    return {
        "peak_memory_mb": values["peak_memory_bytes"] / 1e6,
        "cold_start_seconds": values["first_packet_unix_seconds"] - began,
    }
