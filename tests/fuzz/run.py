"""Runs many cases in worker processes, and prints a summary."""

import argparse
import json
import multiprocessing
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from fuzz import child
from fuzz.case import make_case
from fuzz.play import IS_POSSIBLE, Limits, Result, play
from fuzz.seeds import KINDS, Seeds, make_seeds

_SHARES = {"video": 0.4, "photo": 0.4, "text": 0.2}
# Whole photos that are refused by the action: makeup is not read from one without colour or of
# several pages, and these formats are not painted.
_REFUSED = {
    "photo": ("grey.jpg", "pages.tiff"),
    "bytes": ("grey.jpg", "pages.tiff"),
    "picture": (".tiff", ".bmp", ".gif"),
}


@dataclass(frozen=True)
class Job:
    """One case for a worker; the worker has the seeds."""

    kind: str
    seed: str
    number: int
    as_is: bool
    limits: Limits
    keep: Path | None

    def again(self) -> str:
        """The command that repeats this case."""
        as_is = " --as-is" if self.as_is else ""
        return (
            f"python -m tests.fuzz --kind {self.kind} --seed {self.seed} --first {self.number} "
            f"--count 1{as_is} --keep runs/fuzz"
        )


def main(arguments: Sequence[str]) -> int:
    """Returns the exit code: 1 if a case failed, 2 on a system that cannot run cases."""
    args = _parser().parse_args(arguments)
    if not IS_POSSIBLE:
        print(
            "the fuzzer needs Linux: it forks a process for each case and watches it by its pidfd"
        )
        return 2
    seeds = _make_seeds(KINDS if args.kind == "all" else (args.kind,))
    jobs = list(_jobs(args, seeds))
    began = time.monotonic()
    tally = Tally()
    with args.log.open("a", encoding="utf-8") if args.log else nullcontext() as log:
        for job, case, result in _played(jobs, seeds, args.jobs):
            tally.take(job, case, result)
            if log is not None:
                facts = {"kind": job.kind, "number": job.number, **case, **asdict(result)}
                log.write(json.dumps(facts) + "\n")
                log.flush()
    print(tally.text(time.monotonic() - began))
    return 1 if tally.wrong else 0


class Tally:
    """Counts outcomes, and prints each failed case at once."""

    def __init__(self) -> None:
        self.wrong = 0
        self._outcomes: Counter[str] = Counter()
        self._noise: Counter[str] = Counter()
        self._slowest, self._largest = (0.0, ""), (0, "")

    def take(self, job: Job, case: dict[str, str], result: Result) -> None:
        name = f"{job.kind} {job.number}"
        self._outcomes[f"{job.kind}: {result.outcome}"] += 1
        self._slowest = max(self._slowest, (result.seconds, name))
        self._largest = max(self._largest, (result.memory_mb, name))
        if result.noise:
            self._noise[result.noise.splitlines()[0][:80]] += 1
        if result.faults:
            self.wrong += 1
            print(f"WRONG {name} ({case['name']}; {case['damage']}; {case['command']})")
            for fault in result.faults:
                print(f"    {fault}")
            print(f"    {job.again()}", flush=True)

    def text(self, seconds: float) -> str:
        """The summary, several lines."""
        count = self._outcomes.total()
        lines = [f"{count} cases in {seconds:.0f} s, {self.wrong} of them wrong"]
        lines += [f"  {n:6d}  {outcome}" for outcome, n in sorted(self._outcomes.items())]
        lines.append("longest {} s ({}), largest {} MB ({})".format(*self._slowest, *self._largest))
        lines += [f"printed by libraries, {n} times: {t}" for t, n in self._noise.most_common(9)]
        return "\n".join(lines)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--kind", choices=(*KINDS, "all"), default="all")
    parser.add_argument("--count", type=int, default=1000, help="cases; `all` shares them out")
    parser.add_argument("--seed", default="1", help="any text; another one, other cases")
    parser.add_argument("--first", type=int, default=0, help="the first case's number")
    parser.add_argument("--jobs", type=int, default=2, help="processes at the same time")
    parser.add_argument("--as-is", action="store_true", help="whole files, which are not refused")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="store inputs that go wrong")
    parser.add_argument("--log", type=Path, metavar="FILE", help="append one JSON line a case")
    parser.add_argument("--seconds", type=float, default=Limits.seconds, help="limit of a case")
    parser.add_argument("--most-mb", type=int, default=Limits.most_mb, help="limit of a case")
    return parser


def _make_seeds(kinds: Sequence[str]) -> dict[str, Seeds]:
    """Make the seeds in another process: codecs and OpenCL leave threads, which forbid a fork."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as maker:
        seeds_by_kind = dict(zip(kinds, maker.map(_prepare, kinds), strict=True))
    for kind, seeds in seeds_by_kind.items():
        print(f"{kind}: {len(seeds.files)} whole files, mark {seeds.mark}")
        for name, reason in seeds.left_out.items():
            print(f"  left out {name}: {reason}")
    return seeds_by_kind


def _prepare(kind: str) -> Seeds:
    seeds = make_seeds(kind)
    child.compile_kernels(kind, seeds.files)
    return seeds


def _jobs(args: argparse.Namespace, seeds: dict[str, Seeds]) -> Iterator[Job]:
    limits = replace(Limits(), seconds=args.seconds, most_mb=args.most_mb)
    for kind, whole in seeds.items():
        count = args.count if args.kind != "all" else round(args.count * _SHARES[kind])
        if args.as_is:
            count = min(count, len(whole.files))
        for number in range(args.first, args.first + count):
            yield Job(kind, args.seed, number, args.as_is, limits, args.keep)


_seeds: dict[str, Seeds] = {}  # in a worker


def _start_worker(seeds: dict[str, Seeds]) -> None:
    _seeds.update(seeds)
    child.warm_up()


def _play(job: Job) -> tuple[dict[str, str], Result]:
    case = make_case(job.kind, job.seed, job.number, _seeds[job.kind], job.as_is)
    result = play(case, job.limits, job.keep)
    may_be_refused = case.name.endswith(_REFUSED.get(case.action, ()))
    if job.as_is and result.outcome != "done" and not (result.faults or may_be_refused):
        result.faults.append(f"a whole file: {result.outcome} {result.detail}")
    return {"name": case.name, "damage": case.damage, "command": case.command}, result


def _played(
    jobs: Sequence[Job], seeds: dict[str, Seeds], workers: int
) -> Iterator[tuple[Job, dict[str, str], Result]]:
    """Results in the order of the jobs. Workers fork while this process has a single thread."""
    context = multiprocessing.get_context("fork")
    pool = ProcessPoolExecutor(workers, context, initializer=_start_worker, initargs=(seeds,))
    with pool:
        for job, (case, result) in zip(jobs, pool.map(_play, jobs), strict=True):
            yield job, case, result
