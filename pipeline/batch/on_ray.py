"""Jobs of a batch on the machines of a Ray cluster. Needs the extra `ray`.

A job is a task with its CPUs declared. What a task reports comes back as the items of its
generator: progress, with `ship` the pieces of its files, and in the end the results.
"""

import os
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

# Ray's own clusters report their use to its makers unless this is set before it is imported.
os.environ["RAY_USAGE_STATS_ENABLED"] = "0"

import ray
from makeup_video.pipeline.batch.job import Done, Failed, Job, JobLook, JobProgress, Result, run_job
from makeup_video.pipeline.batch.journal import identity
from makeup_video.pipeline.batch.plan import adopt
from makeup_video.pipeline.errors import StoppedError, UsageError, WorkerError, option
from makeup_video.pipeline.files.output_file import (
    OutputFile,
    part_of,
    target_of,
    write_errors,
)
from makeup_video.pipeline.files.part_file import remove_ended
from makeup_video.pipeline.media.input_file import local_file
from ray.exceptions import RayError, RayTaskError

_CPUS = 2  # one film keeps two cores busy
_ATTEMPTS = 3  # a job whose machine is lost is tried twice more
_CONNECT_SECONDS = 10.0
_PIECE_BYTES = 16_000_000  # of a file that is shipped


class _Piece(NamedTuple):
    """A piece of the output of the look at this place in the job; the pieces come in order."""

    look: int
    data: bytes


@contextmanager
def cluster(address: str) -> Iterator[None]:
    """Connect to a cluster within the block.

    address: host:port of its head, or `auto` for the one that this machine belongs to.
    Raises WorkerError within some ten seconds where there is none.
    """
    _check_reachable(address)
    try:
        ray.init(address=address, log_to_driver=False, logging_level="error")
    except (ConnectionError, RuntimeError, ValueError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise WorkerError(
            f"{option('ray')}: no cluster at {address} ({reason}): start one with "
            "`ray start --head`"
        ) from error
    try:
        yield
    finally:
        ray.shutdown()


def _check_reachable(address: str) -> None:
    """Ray itself would try for minutes. Raises UsageError, WorkerError."""
    if address == "auto":
        return
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if not (colon and host and port.isdecimal()):
        raise UsageError(f"{option('ray')} must be auto or HOST:PORT, got {address!r}")
    try:
        socket.create_connection((host, int(port)), _CONNECT_SECONDS).close()
    except (OSError, OverflowError) as error:
        raise WorkerError(
            f"{option('ray')}: no cluster answers at {address} ({error}): check the address, or "
            "start one with `ray start --head`"
        ) from error


def ray_workers(count: int | None = None, *, ship: bool = False) -> "list[RayWorker]":
    """As many workers as the cluster has CPUs for, two for each; or `count`.

    ship: send inputs and outputs through the cluster, where the machines share no folder.
    """
    sizes = [int(node["Resources"].get("CPU", 0)) for node in ray.nodes() if node["Alive"]]
    cpus = max(1, min(_CPUS, max(sizes, default=1)))
    if count is None:
        count = max(1, sum(size // cpus for size in sizes))
    if count < 1:
        raise UsageError(f"{option('jobs')} must be at least 1, got {count}")
    return [RayWorker(cpus, ship=ship) for _ in range(count)]


class RayWorker:
    """Does one job at a time on some machine of the cluster; see Worker.

    A job whose process or machine is lost is tried again elsewhere, up to twice.
    """

    def __init__(self, cpus: int, *, ship: bool = False) -> None:
        self._cpus, self._ship = cpus, ship
        self._task: Any = None
        self._stopped = False

    def run(self, job: Job, report: Callable[[JobProgress], None]) -> list[Result]:
        was = {one.output: identity(one.output) for one in _absolute(job).looks}
        reason = ""
        for _ in range(_ATTEMPTS):
            try:
                return self._once(job, was, report)
            except RayTaskError as error:  # the task's own error, the same on every machine
                cause = error.cause or error
                return _failed(job, f"{type(cause).__name__}: {cause}".splitlines()[0])
            except RayError as error:
                if self._stopped:
                    raise StoppedError("stopped by the user") from None
                reason = type(error).__name__
        return _failed(job, f"its machine was lost {_ATTEMPTS} times ({reason})")

    def stop(self) -> None:
        """End the task at once. Any thread may call this."""
        self._stopped = True
        if (task := self._task) is not None:
            with suppress(RayError, ValueError):
                ray.cancel(task, force=True)

    def _once(
        self, job: Job, was: dict[str, list[int] | None], report: Callable[[JobProgress], None]
    ) -> list[Result]:
        pieces = _put_file(job.source) if self._ship else None
        task = _TASK.options(num_cpus=self._cpus).remote(_absolute(job), was, pieces)
        self._task = task
        with ExitStack() as stack:
            outputs = [_Arriving(job, one, stack) for one in job.looks] if self._ship else []
            for item in task:
                message = ray.get(item)
                if isinstance(message, JobProgress):
                    report(message)
                elif isinstance(message, _Piece):
                    outputs[message.look].append(message.data)
                else:
                    results = [one._replace(output=look.output)
                               for one, look in zip(message, job.looks, strict=True)]  # fmt: skip
                    for output, result in zip(outputs, results, strict=False):
                        if isinstance(result, Done):
                            output.keep()
                    return results
        raise RayError("the task ended without results")


def _failed(job: Job, reason: str) -> list[Result]:
    error = WorkerError(f"the cluster could not paint it: {reason}")
    return [Failed(one.output, error) for one in job.looks]


class _Arriving:
    """An output whose pieces arrive from another machine; removed when it is not kept."""

    def __init__(self, job: Job, look: JobLook, stack: ExitStack) -> None:
        source, overwrite = Path(job.source), job.settings.overwrite
        self._target = OutputFile(Path(look.output), source, overwrite=overwrite)
        stack.callback(self._target.discard)
        self._path = Path(look.output)

    def append(self, data: bytes) -> None:
        with write_errors(self._path), self._target.own_path.open("ab") as file:
            file.write(data)

    def keep(self) -> None:
        self._target.keep()


def _absolute(job: Job) -> Job:
    """The same job for a process in another folder."""
    looks = (replace(one, output=os.path.abspath(one.output)) for one in job.looks)
    return replace(job, source=os.path.abspath(job.source), looks=tuple(looks))


def _put_file(path: str) -> list[Any]:
    """Put a file into the object store, in pieces. Raises InputError."""
    with local_file(path).open("rb") as file:
        return [ray.put(data) for data in _pieces(file)]


def _pieces(file: Any) -> Iterator[bytes]:
    while data := file.read(_PIECE_BYTES):
        yield data


def _paint(
    job: Job, was: dict[str, list[int] | None], pieces: Sequence[Any] | None
) -> Iterator[Any]:
    """Runs on a machine of the cluster: yields progress, pieces of files, and the results."""
    if pieces is None:
        yield from _in_shared_folder(job, was)
        return
    with TemporaryDirectory(prefix="makeup-video-") as folder:
        here = _received(job, Path(folder), pieces)
        results: list[Result] = []
        for message in _with_progress(here):
            if isinstance(message, JobProgress):
                yield message
            else:
                results = message
        for number, result in enumerate(results):
            if isinstance(result, Done):
                with open(result.output, "rb") as file:
                    yield from (_Piece(number, data) for data in _pieces(file))
        yield [_with_name(one, here.source, job.source) for one in results]


# Ray's own retries would repeat the progress that was reported already.
_TASK: Any = ray.remote(
    max_retries=0, scheduling_strategy="SPREAD", _generator_backpressure_num_objects=16
)(_paint)


def _in_shared_folder(job: Job, was: dict[str, list[int] | None]) -> Iterator[Any]:
    """Paint what an earlier attempt on a lost machine has not finished."""
    known: dict[str, Result] = {}
    for look in job.looks:
        remove_ended(part_of(target_of(Path(look.output))))
        if (done := adopt(job, look, was[look.output])) is not None:
            known[look.output] = done
    left = job.only({one.output for one in job.looks} - set(known))
    for message in _with_progress(left) if left.looks else iter([[]]):
        if isinstance(message, JobProgress):
            yield message
        else:
            known |= {one.output: one for one in message}
            yield [known[one.output] for one in job.looks]


def _received(job: Job, folder: Path, pieces: Sequence[Any]) -> Job:
    """The same job on files of a folder of this machine, once the input has arrived."""
    source = folder / Path(job.source).name
    with source.open("wb") as file:
        for piece in pieces:
            file.write(ray.get(piece))
    looks = []
    for number, one in enumerate(job.looks):
        place = folder / str(number) / Path(one.output).name
        place.parent.mkdir()
        looks.append(replace(one, output=str(place)))
    return replace(job, source=str(source), looks=tuple(looks))


def _with_name(result: Result, here: str, source: str) -> Result:
    """A result whose error names the input where the user has it."""
    if isinstance(result, Done):
        return result
    error = result.error
    return Failed(result.output, type(error)(error.marked.replace(here, source)))


def _with_progress(job: Job) -> Iterator[Any]:
    """What run_job reports while it runs in another thread, then the results."""
    messages: SimpleQueue[Any] = SimpleQueue()

    def work() -> None:
        try:
            messages.put(run_job(job, messages.put))
        except BaseException as error:  # noqa: BLE001  # raised again by the generator
            messages.put(error)

    threading.Thread(target=work, daemon=True).start()
    while True:
        message = messages.get()
        if isinstance(message, BaseException):
            raise message
        yield message
        if isinstance(message, list):
            return
