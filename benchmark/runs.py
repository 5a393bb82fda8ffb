"""The kinds of runs that `makeup-video bench` compares; each run returns plain numbers."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import av
from makeup_video.benchmark.videos import CODEC, CRF, PRESET, X264_OPTIONS
from makeup_video.pipeline import (
    InputError,
    InstallError,
    Look,
    Report,
    Settings,
    process_video,
)
from makeup_video.pipeline.engine.machine import cpu_seconds_of_children
from makeup_video.pipeline.engine.runner import Observe

SETTINGS = Settings(codec="h264", preset=PRESET, crf=CRF, overwrite=True)
LEAST_PAINTED = 0.95  # least share of painted frames, since a run that paints nothing is quick
# Where PoCL and PyOpenCL keep what they compile.
_KERNEL_CACHES = ("POCL_CACHE_DIR", "XDG_CACHE_HOME")


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


def time_run(work: Callable[[], int]) -> Run:
    """Wall and CPU time of a piece of work that returns its number of frames."""
    wall, cpu = time.perf_counter(), time.process_time()
    frames = work()
    return Run(frames, time.perf_counter() - wall, time.process_time() - cpu)


def run_bare(source: Path, target: Path, threads: tuple[int, int]) -> Run:
    """The limit: a plain loop that decodes and encodes with the same codec settings, without audio.

    threads: of the decoder and of the encoder; 0: FFmpeg's own choice.
    """
    return time_run(lambda: transcode(source, [target], threads))


def transcode(source: Path, targets: Sequence[Path], threads: tuple[int, int]) -> int:
    """Decode a video and encode it for all targets at the same time; returns its frames."""
    frames = 0
    with av.open(str(source)) as container, ExitStack() as stack:
        video = container.streams.video[0]
        video.thread_type, video.thread_count = "AUTO", threads[0]
        outs = [stack.enter_context(av.open(str(target), "w")) for target in targets]
        streams: list[Any] = []
        for out in outs:
            stream: Any = out.add_stream(CODEC, rate=video.average_rate, options=X264_OPTIONS)
            stream.width, stream.height, stream.pix_fmt = video.width, video.height, video.pix_fmt
            stream.codec_context.time_base = video.time_base
            stream.codec_context.thread_count = threads[1]
            stream.codec_context.thread_type = "AUTO"
            streams.append(stream)
        for picture in container.decode(video):
            picture.pict_type = 0
            for out, stream in zip(outs, streams, strict=True):
                out.mux(stream.encode(picture))
            frames += 1
        for out, stream in zip(outs, streams, strict=True):
            out.mux(stream.encode(None))
    return frames


def run_product(
    source: Path,
    target: Path,
    look: Look | None,
    settings: Settings = SETTINGS,
    observe: Observe | None = None,
) -> tuple[Run, Report]:
    """Run the product in this process; look None is `--look none`.

    Raises InputError when too few frames were painted to measure painting.
    """
    reports: list[Report] = []

    def work() -> int:
        reports.append(process_video(source, target, look, replace(settings, observe=observe)))
        return reports[0].frames_out

    run = time_run(work)
    if look is not None:
        check_painted(reports[0].painted_frames, run.frames)
    return run, reports[0]


def check_painted(painted: int | None, frames: int) -> None:
    """Raises InputError when a run painted too few frames to measure painting."""
    if (painted or 0) < LEAST_PAINTED * frames:
        raise InputError(
            f"a face was painted in {painted or 0} of {frames} frames, at least "
            f"{LEAST_PAINTED:.0%} are needed to measure painting: give a clip of somebody who is "
            "seen all the time"
        )


def run_command(
    source: Path,
    target: Path,
    look_words: tuple[str, ...],
    *,
    words: tuple[str, ...] = (),
    environment: Mapping[str, str] | None = None,
    sample_seconds: float | None = None,
    stderr: int | None = None,
    python: str = sys.executable,
) -> dict[str, Any]:
    """Run the real command in its own process; returns the values of its report and four more.

    start_seconds: from the start of the process to the first packet written; None if the report
    does not say.  memory: [[seconds, MB], ...] every sample_seconds; empty if that is None.
    wall_seconds, all_cpu_seconds: of the whole process and its children, start and end included.

    target: has {look} in its name for several looks; the values of each are then in "outputs".
    look_words: what is painted, such as ("--ref", "look.jpg").  words: further options.
    environment: variables to add.  stderr: as for subprocess.Popen.  python: the interpreter whose
    version of the product runs.
    """
    report = target.with_suffix(".json")
    command = [python, "-m", "makeup_video", str(source), "-q", "-y", *words]
    command += ["-o", str(target), *look_words, "--report", str(report)]
    command += ["--codec", "h264", "--preset", PRESET, "--crf", str(CRF)]
    began, wall, cpu = time.time(), time.perf_counter(), _cpu_of_children()
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stderr=stderr,
        env={**os.environ, **_as_installed(target.parent), **(environment or {})},
    )
    memory = _memory_of(process, sample_seconds) if sample_seconds else []
    if code := process.wait():
        raise subprocess.CalledProcessError(code, command)
    wall, cpu = time.perf_counter() - wall, _cpu_of_children() - cpu
    values: dict[str, Any] = json.loads(report.read_text(encoding="utf-8"))
    # with further words it may be an excerpt in which nobody is seen
    if not words and values.get("painted_frames") is not None:
        check_painted(values["painted_frames"], values["frames_out"])
    first = values.get("first_packet_unix_seconds")
    more = {"wall_seconds": wall, "all_cpu_seconds": cpu, "memory": memory}
    return {**values, **more, "start_seconds": None if first is None else first - began}


def _cpu_of_children() -> float:
    """CPU seconds of all child processes that have ended, and of their children.

    Raises InstallError.
    """
    seconds = cpu_seconds_of_children()
    if seconds is None:
        raise InstallError("this system tells no CPU time of child processes: run it on another")
    return seconds


def _as_installed(folder: Path) -> dict[str, str]:
    """Variables that keep compiled modules in a folder, if this environment keeps none.

    An installed package has compiled modules. Without them each start would compile two hundred
    modules.
    """
    if not sys.dont_write_bytecode:
        return {}
    return {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": str(folder / "modules")}


def empty_caches(folder: Path) -> dict[str, str]:
    """Environment variables that put the kernel caches into a folder that has none yet."""
    return {name: str(folder / name.lower()) for name in _KERNEL_CACHES}


def _memory_of(process: "subprocess.Popen[bytes]", every_seconds: float) -> list[list[float]]:
    """[seconds, MB] at intervals until the process ends; empty where memory_mb is None."""
    began, samples = time.monotonic(), []
    # a process that has ended holds no memory, even before its exit code is collected
    while process.poll() is None and (size_mb := memory_mb(process.pid)):
        samples.append([time.monotonic() - began, size_mb])
        time.sleep(every_seconds)
    return samples


def memory_mb(process: int | str) -> float | None:
    """Resident memory of a process in MB ("self": this one); None if the system reports none."""
    try:
        pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except (OSError, IndexError):  # another system, or the process ended just now
        return None
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
