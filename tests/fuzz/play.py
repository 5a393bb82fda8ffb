"""Plays a case in its own process, with limits, and judges the result and the files left."""

import faulthandler
import json
import os
import re
import resource
import select
import shutil
import signal
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NoReturn

from fuzz import check, child
from fuzz.case import Case
from fuzz.child import FAULT, Answer

IS_POSSIBLE = hasattr(os, "pidfd_open")  # Linux
_OLD = b"an older output\n" * 9
_SHOWN = 4000  # characters of output or of a traceback
# The command's own lines in a successful run; --quiet suppresses all others.
_OURS = re.compile(
    r"changed: |dropped: |the input is damaged: |no face was found|nothing was painted"
    r"|faces under |audio #\d+ \(\w+\): few players |in\.\w+: no makeup was found"
)


@dataclass(frozen=True)
class Limits:
    """Limits of one case.

    seconds: run time.  most_mb: resident memory.  address_mb: address space, beyond which
    allocations fail; this protects the machine. Address space is free, so the limit is larger.
    """

    seconds: float = 60
    most_mb: int = 2000
    address_mb: int = 12_000


@dataclass
class Result:
    """The verdict on one case.

    outcome: as in Answer.  faults: one line each.  noise: output of libraries.
    """

    outcome: str
    detail: str
    faults: list[str] = field(default_factory=list)
    noise: str = ""
    seconds: float = 0.0
    memory_mb: int = 0


@dataclass
class _Ended:
    """How a process ended.

    code: the exit code, negative for a signal, None if the process ran out of time.
    """

    code: int | None
    memory_mb: int
    answer: Any
    stderr: str
    stdout: str


def play(case: Case, limits: Limits, keep: Path | None = None) -> Result:
    """Run and judge one case. keep: folder for the input and the verdict of a failed case."""
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="fuzz_") as folder:
        place = Path(folder) / "case"
        place.mkdir()
        (place / case.input).write_bytes(case.data)
        if case.has_old:
            (place / str(case.output)).write_bytes(_OLD)
        result = _judged(case, place, limits)
        result.seconds = round(time.monotonic() - began, 2)
        if result.faults and keep is not None:
            _keep(case, result, keep)
    return result


def _judged(case: Case, place: Path, limits: Limits) -> Result:
    """Run the case. If the run succeeds, check the output in a second process, because a crash of
    the decoder must not end this one."""
    job = child.run_command if case.by_command else child.run
    ended = forked(lambda: job(case), place, limits)
    answer, faults = _answer(case, ended, place, limits)
    result = Result(answer.outcome, answer.detail[-_SHOWN:], faults, memory_mb=ended.memory_mb)
    if not faults:
        result.noise = _noise(case, ended, answer)
    if case.by_command and result.noise:
        faults.append(f"printed beside our lines: {result.noise[:200]}")
    if ended.memory_mb > limits.most_mb:
        faults.append(f"{ended.memory_mb} MB of memory")
    faults += _left_behind(case, place, answer)
    if answer.outcome in ("done", "damaged") and answer.report is not None and not faults:
        judged = forked(lambda: _look_at(case, answer.report or {}), place, limits)
        faults += judged.answer if judged.code == 0 else [f"the check: {judged.stderr[-_SHOWN:]}"]
    return result


def _noise(case: Case, ended: _Ended, answer: Answer) -> str:
    """The lines on stderr and stdout that libraries printed."""
    lines = [line for line in ended.stderr.splitlines() if not _OURS.match(line)]
    if case.by_command and answer.outcome.startswith("refused"):
        lines = [line for line in lines if not line.startswith(answer.outcome.split()[1])]
    if not (case.by_command and case.words[0] == "estimate"):
        lines += ended.stdout.splitlines()
    return "\n".join(lines)


def forked(job: Callable[[], Any], place: Path, limits: Limits) -> _Ended:
    """Run `job` in a child process, in the folder `place`."""
    stderr, stdout, answer = (place.parent / name for name in ("stderr", "stdout", "answer"))
    for path in (stderr, stdout, answer):
        path.write_bytes(b"")
    pid = os.fork()
    if pid == 0:
        _in_child(job, place, limits)
    watched = os.pidfd_open(pid)
    on_time = bool(select.select([watched], [], [], limits.seconds)[0])
    os.close(watched)
    if not on_time:
        os.kill(pid, signal.SIGKILL)
    _, status, used = os.wait4(pid, 0)
    text = answer.read_text()
    return _Ended(
        os.waitstatus_to_exitcode(status) if on_time else None,
        used.ru_maxrss // 1024,
        json.loads(text) if text else None,
        stderr.read_text(errors="replace"),
        stdout.read_text(errors="replace"),
    )


def _in_child(job: Callable[[], Any], place: Path, limits: Limits) -> NoReturn:
    code = 99
    try:
        os.chdir(place)
        for number, name in ((1, "stdout"), (2, "stderr")):
            os.dup2(os.open(place.parent / name, os.O_WRONLY | os.O_APPEND), number)
        resource.setrlimit(resource.RLIMIT_AS, (limits.address_mb << 20,) * 2)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 30,) * 2)
        log = os.dup(2)  # the command may redirect file descriptor 2 for its libraries
        signal.signal(signal.SIGSEGV, signal.SIG_DFL)  # PoCL's handler would continue after a crash
        faulthandler.enable(log)
        faulthandler.dump_traceback_later(0.9 * limits.seconds, file=log)
        value = job()
        plain = asdict(value) if isinstance(value, Answer) else value
        (place.parent / "answer").write_text(json.dumps(plain))
        code = 0
    except BaseException:  # noqa: BLE001  # a child must never return into the parent's code
        os.write(2, traceback.format_exc().encode())
    finally:
        os._exit(code)


def _answer(case: Case, ended: _Ended, place: Path, limits: Limits) -> tuple[Answer, list[str]]:
    """The child's answer and its faults; a FAULT if the child gave no answer."""
    if ended.code is None:
        return Answer(FAULT, ended.stderr), [f"still at work after {limits.seconds:g} s"]
    if ended.code < 0:
        name = signal.Signals(-ended.code).name
        return Answer(FAULT, ended.stderr), [f"ended by {name}"]
    if case.by_command:
        answer = child.answer_of_command(ended.code, ended.stderr, place)
    elif ended.answer is None:
        return Answer(FAULT, ended.stderr), [f"ended with exit code {ended.code} and no answer"]
    else:
        answer = Answer(**ended.answer)
    return answer, [_in_short(answer.detail)] if answer.outcome == FAULT else []


def _in_short(detail: str) -> str:
    """The most informative line of a message or of a traceback."""
    lines = detail.strip().splitlines()
    return lines[-1 if lines[0].startswith("Traceback") else 0][:300]


def _left_behind(case: Case, place: Path, answer: Answer) -> list[str]:
    """Faults of the folder: files left behind, missing or changed."""
    faults = []
    own = place / case.input
    if not own.exists() or own.read_bytes() != case.data:
        faults.append("the input was changed")
    left = {path.name for path in place.iterdir()} - {case.input}
    done = answer.outcome in ("done", "damaged")
    wanted = set()
    if case.output is not None and (done or case.has_old):
        wanted.add(case.output)
    if case.by_command and case.output is not None and done:
        wanted.add(child.REPORT)
    if case.by_command and case.action == "look" and done:
        wanted.add("out.png")
    if left - wanted:
        faults.append(f"left behind: {', '.join(sorted(left - wanted))}")
    if wanted - left:
        faults.append(f"not there: {', '.join(sorted(wanted - left))}")
    if case.has_old and not (wanted - left):
        is_old = (place / str(case.output)).read_bytes() == _OLD
        if is_old == done:
            faults.append("the old output " + ("is still there" if done else "was changed"))
    return faults


def _look_at(case: Case, report: dict[str, Any]) -> list[str]:
    """Compare the output with its report; runs in a child process."""
    if report["is_picture"]:
        return check.picture_faults(Path(str(case.output)))
    return check.video_faults(Path(case.input), Path(str(case.output)), report, case.is_trimmed)


def _keep(case: Case, result: Result, keep: Path) -> None:
    folder = keep / f"{case.kind}_{case.seed}_{case.number}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / case.input).write_bytes(case.data)
    lines = (case.command, case.damage, result.outcome, *result.faults, result.detail)
    (folder / "how.txt").write_text("\n".join(lines) + "\n", errors="replace")
