"""One run of each kind that `makeup-video bench` compares: each returns plain numbers."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import av
from makeup_video.benchmark.films import CODEC, CRF, LIKE_A_FILM, PRESET
from makeup_video.pipeline import InputError, Look, Report, Settings, process_video
from makeup_video.pipeline.engine.runner import Observe

SETTINGS = Settings(codec="h264", preset=PRESET, crf=CRF, overwrite=True)
LEAST_PAINTED = 0.95  # of the frames: what paints nothing is quick
_EMPTY_CACHES = (
    "POCL_CACHE_DIR",
    "XDG_CACHE_HOME",
)  # where PoCL and PyOpenCL keep what they compile


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


class RunTimer:
    """Wall and CPU time since it was made."""

    def __init__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def run(self, frames: int) -> Run:
        return Run(frames, time.perf_counter() - self._wall, time.process_time() - self._cpu)


def run_bare(source: Path, target: Path, threads: tuple[int, int]) -> Run:
    """The limit: a plain loop of decoding and encoding, the same codec settings, no audio.

    threads: of the decoder and of the encoder, 0 is FFmpeg's own choice.
    """
    clock, frames = RunTimer(), 0
    with av.open(str(source)) as box, av.open(str(target), "w") as out:
        video = box.streams.video[0]
        video.thread_type, video.thread_count = "AUTO", threads[0]
        stream: Any = out.add_stream(CODEC, rate=video.average_rate, options=LIKE_A_FILM)
        stream.width, stream.height, stream.pix_fmt = video.width, video.height, video.pix_fmt
        stream.codec_context.time_base = video.time_base
        stream.codec_context.thread_count, stream.codec_context.thread_type = threads[1], "AUTO"
        for picture in box.decode(video):
            picture.pict_type = 0
            out.mux(stream.encode(picture))
            frames += 1
        out.mux(stream.encode(None))
    return clock.run(frames)


def run_product(
    source: Path,
    target: Path,
    look: Look | None,
    settings: Settings = SETTINGS,
    observe: Observe | None = None,
) -> tuple[Run, Report]:
    """The product in this process; None is `--look none`. Raises InputError when it had too few
    faces to paint."""
    clock = RunTimer()
    report = process_video(source, target, look, replace(settings, observe=observe))
    run = clock.run(report.frames_out)
    if look is not None:
        check_painted(report.painted_frames, report.frames_out)
    return run, report


def check_painted(painted: int | None, frames: int) -> None:
    """Raises InputError where a run painted too few frames to be measured."""
    if (painted or 0) < LEAST_PAINTED * frames:
        raise InputError(
            f"a face was painted in {painted or 0} of {frames} frames, at least "
            f"{LEAST_PAINTED:.0%} are needed to measure painting: give a clip of somebody who is "
            "seen all the time"
        )


def run_command(
    source: Path,
    target: Path,
    worn: tuple[str, ...],
    *,
    words: tuple[str, ...] = (),
    environment: Mapping[str, str] | None = None,
    sample_seconds: float | None = None,
    stderr: int | None = None,
) -> dict[str, Any]:
    """The real command in its own process: the values of its report, and start_seconds, from its start
    to the first packet written; with sample_seconds also memory: [[seconds, MB], ...].

    worn: what is painted, such as ("--ref", "look.jpg").  words: more of its options.  stderr: as
    of subprocess.Popen.
    """
    report = target.with_suffix(".json")
    command = [sys.executable, "-m", "makeup_video.cli", str(source), "-q", "-y", *words]
    command += ["-o", str(target), *worn, "--report", str(report)]
    command += ["--codec", "h264", "--preset", PRESET, "--crf", str(CRF)]
    began = time.time()
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stderr=stderr,
        env={**os.environ, **(environment or {})},
    )
    memory = _memory_of(process, sample_seconds) if sample_seconds else []
    if code := process.wait():
        raise subprocess.CalledProcessError(code, command)
    values: dict[str, Any] = json.loads(report.read_text(encoding="utf-8"))
    if values["painted_frames"] is not None:
        check_painted(values["painted_frames"], values["frames_out"])
    values["start_seconds"] = values["first_packet_unix_seconds"] - began
    return {**values, "memory": memory}


def first_time(folder: Path) -> dict[str, str]:
    """The environment of a machine where our kernels were never compiled."""
    return {name: str(folder / name.lower()) for name in _EMPTY_CACHES}


def _memory_of(process: "subprocess.Popen[bytes]", every_seconds: float) -> list[list[float]]:
    """[seconds, MB in memory] now and then until it ends; nothing where the system does not tell."""
    began, samples = time.monotonic(), []
    # it has ended when it holds nothing, though nobody has asked yet how
    while process.poll() is None and (size_mb := memory_mb(process.pid)):
        samples.append([time.monotonic() - began, size_mb])
        time.sleep(every_seconds)
    return samples


def memory_mb(process: int | str) -> float | None:
    """What a process ("self": this one) holds in memory; None where the system does not tell."""
    try:
        pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except (OSError, IndexError):  # another system, or it ended just now
        return None
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
