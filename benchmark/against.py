"""`makeup-video bench --against PYTHON`: two versions of the product in turn on the same video.

The other version may be older, so the two share only the command line: each version runs in a
process of its own with its own interpreter.
"""

import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from statistics import median
from tempfile import TemporaryFile
from typing import Any

from makeup_video.benchmark.harness import Bench, in_turn, middle
from makeup_video.benchmark.runs import Run, check_painted, run_command
from makeup_video.benchmark.videos import CODEC, CRF, PRESET, Video
from makeup_video.pipeline.errors import UsageError, option

_NAME = "makeup-video"
# Nothing of this process may lead the other interpreter to this version.
_ENVIRONMENT = {"PYTHONPATH": "", "PYTHONHOME": "", "PYTHONSAFEPATH": "1"}
_ASKING_SECONDS = 60  # for `--version`: the first start compiles the modules
_WARM_WORDS = ("--end", "1")
_WARM_RUNS = 2  # the first run compiles the kernels, the second keeps them as binaries
_CODEC = ("decode", "encode")
_MEASURES: dict[str, Callable[["Ran"], float | None]] = {
    "cpu": lambda ran: ran.run.cpu_seconds,
    "stages": lambda ran: ran.stages_ms,
    "wall": lambda ran: ran.run.seconds,
    "start": lambda ran: ran.start_seconds,
    "memory": lambda ran: ran.peak_memory_mb,
}


@dataclass(frozen=True, slots=True)
class Version:
    """A version of the product that can be run.

    name: as `makeup-video --version` prints it, such as "0.2.0".  python: its interpreter.
    """

    name: str
    python: str

    @property
    def environment(self) -> dict[str, str]:
        """The variables that its runs need."""
        return {} if self.python == sys.executable else _ENVIRONMENT


@dataclass(frozen=True, slots=True)
class Ran:
    """One run of one version's command.

    run: frames, wall and CPU seconds of the whole process, start-up included.
    start_seconds: until the first packet was written.  peak_memory_mb: of the process.
    Both are None for a version whose report lacks them.
    stage_ms: CPU ms a frame of each stage's own thread, including the two stages of the codec.
    """

    run: Run
    start_seconds: float | None
    peak_memory_mb: float | None
    stage_ms: Mapping[str, float] = field(default_factory=dict)

    @property
    def stages_ms(self) -> float | None:
        """CPU ms a frame of all stages except the codec's; None if the report lacks them."""
        own = [ms for name, ms in self.stage_ms.items() if name not in _CODEC]
        return sum(own) or None


def this_version() -> Version:
    """The version that this process belongs to."""
    return Version(version(_NAME), sys.executable)


def other_version(python: str) -> Version:
    """The version that another interpreter has installed. Raises UsageError if it has none."""
    command = [python, "-m", "makeup_video", "--version"]
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            env={**os.environ, **_ENVIRONMENT},
            timeout=_ASKING_SECONDS,
            check=False,
        )
        words = done.stdout.split()
        reason = _last_line(done.stderr) or "it printed no version"
    except (OSError, subprocess.TimeoutExpired) as error:
        words, reason = [], str(error)
    if len(words) != 2 or words[0] != _NAME:
        raise UsageError(
            f"{option('against')} must be a Python interpreter that has {_NAME}, such as "
            f"old/.venv/bin/python, got {python!r}: {reason}"
        )
    return Version(words[1], python)


def compare_versions(bench: Bench, heights: list[int], other: Version) -> dict[str, Any]:
    """Run this version and another in turn (A B, B A, ...), at each size.

    cpu, stages, wall, start, memory of each size: this version's value divided by the other's, as
    {"ratio": the median of the rounds, "spread": [least, most]}; None if a version does not report
    the value.  by_stage of each size: the same for every stage that both versions have, with the
    median CPU ms a frame of each version as "this" and "other".
    """
    ours = this_version()
    sizes = {}
    for height in heights:
        video = bench.video(height)
        sizes[f"{height}p"] = _one_size(bench, video, f"{height}p", ours, other)
    return {
        "this": ours.name,
        "other": other.name,
        "other_python": other.python,
        "clip": bench.source.name,
        "codec": f"{CODEC} {PRESET} crf {CRF}",
        "rounds": bench.rounds,
        "sizes": sizes,
    }


def _one_size(
    bench: Bench, video: Video, name: str, ours: Version, other: Version
) -> dict[str, Any]:
    ran: dict[str, list[Ran]] = {"this": [], "other": []}

    def work(side: str, which: Version) -> Run:
        ran[side].append(_run(bench, video, which))
        return ran[side][-1].run

    sides = {"this": ours, "other": other}
    for which in sides.values():
        bench.log(f"{name}: {which.name} warms up")
        for _ in range(_WARM_RUNS):
            _run(bench, video, which, _WARM_WORDS)
    runs = in_turn(
        bench, name, {side: partial(work, side, which) for side, which in sides.items()},
        bench.rounds,
    )  # fmt: skip
    return {
        "film": video.description,
        **{
            side: {**middle(runs[side]), **{
                key: _middle_of([getattr(one, key) for one in ran[side]])
                for key in ("start_seconds", "peak_memory_mb", "stages_ms")
            }}
            for side in sides
        },
        **compare_runs(ran["this"], ran["other"]),
        "by_stage": compare_stages(ran["this"], ran["other"]),
    }  # fmt: skip


def _run(bench: Bench, video: Video, which: Version, words: tuple[str, ...] = ()) -> Ran:
    """Run the command of a version. Raises UsageError when the version refuses the video or the
    look, and InputError when it paints too few frames."""
    with TemporaryFile("w+", encoding="utf-8", errors="replace") as stderr:
        try:
            values = run_command(
                video.path,
                bench.folder / "against.mp4",
                bench.look_words,
                words=words,
                environment=which.environment,
                stderr=stderr.fileno(),
                python=which.python,
            )
        except subprocess.CalledProcessError as error:
            stderr.seek(0)
            reason = _last_line(stderr.read()) or f"exit code {error.returncode}"
            raise UsageError(
                f"{_NAME} {which.name} ({which.python}) cannot run what is compared: {reason}"
            ) from error
    if not words:
        # of the video's frames, not of those written: a version that loses frames is quick, too
        check_painted(values.get("painted_frames"), video.frames)
    run = Run(values["frames_out"], values["wall_seconds"], values["all_cpu_seconds"])
    peak = values.get("peak_memory_bytes")
    stage_ms = {
        name: 1000 * times["cpu_seconds"] / run.frames
        for name, times in values.get("stages", {}).items()
    }
    return Ran(run, values["start_seconds"], peak and peak / 1e6, stage_ms)


def _last_line(text: str) -> str:
    lines = text.strip().splitlines()
    return lines[-1] if lines else ""


def _middle_of(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return median(known) if known else None


def compare_runs(ours: list[Ran], others: list[Ran]) -> dict[str, dict[str, Any] | None]:
    """The ratio of each measure, as `compare_versions` returns it, from the runs of all rounds."""
    return {key: _ratio(ours, others, read) for key, read in _MEASURES.items()}


def compare_stages(ours: list[Ran], others: list[Ran]) -> dict[str, dict[str, Any]]:
    """The entry `by_stage` of `compare_versions`: the stages that all runs have, in order."""
    found = {}
    for name in ours[0].stage_ms:
        sides = [[_ms_of(name, one) for one in runs] for runs in (ours, others)]
        compared = _ratio(ours, others, partial(_ms_of, name))
        if compared is not None:
            found[name] = {"this": _middle_of(sides[0]), "other": _middle_of(sides[1]), **compared}
    return found


def _ms_of(stage: str, ran: Ran) -> float | None:
    return ran.stage_ms.get(stage)


def _ratio(
    ours: list[Ran], others: list[Ran], read: Callable[[Ran], float | None]
) -> dict[str, Any] | None:
    """The median and the spread of the rounds' ratios; None if a run lacks the value."""
    ratios = []
    for pair in zip(ours, others, strict=True):
        mine, theirs = map(read, pair)
        if mine is None or not theirs:
            return None
        ratios.append(mine / theirs)
    return {"ratio": median(ratios), "spread": [min(ratios), max(ratios)]}
