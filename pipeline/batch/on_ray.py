"""Jobs on the machines of a Ray cluster: those of a batch, or the segments of a video. Needs the
extra `ray`.

A job is a Ray task with its CPUs declared. The task is a generator, whose items are the progress,
with `ship` also the pieces of the job's outputs, and in the end the result.
"""

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Protocol, Self

# Ray's own clusters report their use to its makers unless this is set before it is imported.
os.environ["RAY_USAGE_STATS_ENABLED"] = "0"

import ray
from makeup_video.pipeline.batch.ray_greeting import is_cluster
from makeup_video.pipeline.engine.jobs import (
    CORES_PER_JOB,
    WAS_STOPPED,
    Progress,
    Result,
    Task,
    jobs_at_once,
)
from makeup_video.pipeline.engine.processes import Ended, InProgress, perform
from makeup_video.pipeline.errors import (
    MakeupVideoError,
    StoppedError,
    UsageError,
    WorkerError,
    option,
)
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.files.output_file import OutputFile, write_errors
from makeup_video.pipeline.offline.settings import Settings
from ray.exceptions import RayError, RayTaskError

_ATTEMPTS = 3  # a job whose machine is lost is tried twice more
_CONNECT_SECONDS = 8.0
_PIECE_BYTES = 16_000_000  # of a file that is shipped


class RemoteJob(Protocol):
    """A job that another machine can do.

    source: the file that the job reads.  outputs: the files that it writes.
    """

    settings: Settings

    @property
    def source(self) -> Any: ...

    @property
    def outputs(self) -> Sequence[str]: ...

    def at_full_paths(self) -> Self:
        """The same job for a process in another folder."""
        ...

    def again(self) -> Self:
        """The same job for another machine, once the one that did it is lost."""
        ...

    def moved(self, source: str, outputs: Sequence[str]) -> Self:
        """The same job on other files."""
        ...

    def brought_back(self, result: Any) -> tuple[Any, list[int]]:
        """(the result, as if this job had written its own files; the places of whole outputs).

        result: of this job `at_full_paths` or as `moved`.
        """
        ...

    def without(self, result: Any, at: int, error: MakeupVideoError) -> Any:
        """The result when the output at this place could not be kept; raises the error when
        nothing is left of the result."""
        ...


class _Piece(NamedTuple):
    """A piece of an output; the pieces come in order.  output: the output's place in the job."""

    output: int
    data: bytes


@contextmanager
def cluster(address: str) -> Iterator[None]:
    """Connect to a cluster within the block.

    address: host:port of its head, or `auto` for the cluster that Ray is connected to already, or
    else the one that this machine belongs to.
    Raises UsageError, and WorkerError within some ten seconds where there is no cluster.
    """
    if ray.is_initialized():
        if address != "auto":
            raise UsageError(
                f"Ray is connected to a cluster already: give auto to use that one, got {address}"
            )
        yield
        return
    _check_reachable(address)
    _connect(address)
    try:
        yield
    finally:
        ray.shutdown()


def _check_reachable(address: str) -> None:
    """Try the address first, since Ray would try for minutes. Raises UsageError, WorkerError."""
    if address == "auto" and (address := os.environ.get("RAY_ADDRESS", "auto")) == "auto":
        return  # Ray looks for processes of a cluster on this machine
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if not (colon and host and port.isdecimal()):
        raise UsageError(f"{option('ray')} must be auto or HOST:PORT, got {address!r}")
    if os.environ.get("RAY_AUTH_MODE") == "token":
        return  # the cluster answers nobody without a token, and Ray knows the token
    try:
        is_found = is_cluster(host, int(port), _CONNECT_SECONDS)
    except (OSError, OverflowError) as error:
        raise WorkerError(
            f"{option('ray')}: no cluster answers at {address} ({error}): check the address, or "
            "start one with `ray start --head`"
        ) from error
    if not is_found:
        raise WorkerError(
            f"{option('ray')}: what answers at {address} is no Ray cluster: give the address that "
            "`ray start --head` printed"
        )


def _connect(address: str) -> None:
    """Raises WorkerError."""
    on_main = threading.current_thread() is threading.main_thread()
    handler = signal.getsignal(signal.SIGTERM)
    try:
        ray.init(address=address, log_to_driver=False, logging_level="error")
    except (ConnectionError, RuntimeError, ValueError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise WorkerError(
            f"{option('ray')}: no cluster at {address} ({reason}): start one with "
            "`ray start --head`"
        ) from error
    finally:
        if on_main and handler is not None:  # Ray's handler would end the process silently
            signal.signal(signal.SIGTERM, handler)


def ray_workers(count: int | None = None, *, ship: bool = False) -> "list[RayWorker]":
    """`count` workers; None: as many as the cluster has CPUs for, two CPUs for each worker.

    ship: send inputs and outputs through the cluster, where the machines share no folder.
    """
    sizes = [int(node["Resources"].get("CPU", 0)) for node in ray.nodes() if node["Alive"]]
    cpus = max(1, min(CORES_PER_JOB, max(sizes, default=1)))
    count = jobs_at_once(count, sum(size // cpus for size in sizes))
    files = _SentFiles() if ship else None
    per_machine = max(1, max(sizes, default=1) // cpus)
    return [RayWorker(cpus, files, per_machine) for _ in range(count)]


class RayWorker:
    """Does one job at a time on some machine of the cluster; see Worker. The job is a RemoteJob.

    A job whose process or machine is lost is tried again elsewhere, up to twice.
    files: sends the inputs where the machines share no folder; else None.  per_machine: see Worker.
    """

    def __init__(
        self, cpus: int, files: "_SentFiles | None" = None, per_machine: int | None = None
    ) -> None:
        self._cpus, self._files, self.per_machine = cpus, files, per_machine
        self._task: Any = None
        self._stopped = False

    def run(
        self, task: Task[Any, Progress, Result], job: Any, report: Callable[[Progress], None]
    ) -> Result:
        """See Worker."""
        if self._stopped:
            raise UsageError(WAS_STOPPED)
        reason = ""
        for _ in range(_ATTEMPTS):
            self._check()
            try:
                return self._once(task, job, report).value()  # type: ignore[no-any-return]
            except RayTaskError as error:  # raised by the task itself, so on every machine
                cause = error.cause or error
                reason = f"{type(cause).__name__}: {cause}".splitlines()[0]
                raise WorkerError(f"the cluster could not paint it: {reason}") from error
            except RayError as error:
                if self._stopped:
                    raise StoppedError from None
                reason, job = type(error).__name__, job.again()
        raise WorkerError(f"the machine that did this job was lost {_ATTEMPTS} times ({reason})")

    def stop(self) -> None:
        """End the task at once. Any thread may call this."""
        self._stopped = True
        if (task := self._task) is not None:
            with suppress(RayError, ValueError):
                ray.cancel(task, force=True)

    def _check(self) -> None:
        """Raises StoppedError after `stop`."""
        if self._stopped:
            raise StoppedError

    def _once(self, task: Any, own: RemoteJob, report: Callable[[Any], None]) -> Ended:
        job = own.at_full_paths()
        pieces = (
            None if self._files is None else self._files.pieces_of(str(job.source), self._check)
        )
        self._check()
        self._task = _TASK.options(num_cpus=self._cpus).remote(task, job, pieces)
        if self._stopped:  # by another thread in the meantime, which did not see the task
            self.stop()
        with ExitStack() as stack:
            arriving = () if pieces is None else job.outputs
            outputs = [_Arriving(output, job, stack) for output in arriving]
            for item in self._task:
                message = ray.get(item)
                if isinstance(message, InProgress):
                    report(message.progress)
                elif isinstance(message, _Piece):
                    outputs[message.output].append(message.data)
                elif isinstance(message, Ended):
                    return _kept(message, own, outputs)
        raise RayError("the task ended without a result")


def _kept(ended: Ended, job: RemoteJob, outputs: "Sequence[_Arriving]") -> Ended:
    """What a task ended with, under the job's own file names. Keeps whole outputs that arrived.

    outputs: none where the machines share a folder.
    """
    if ended.error is not None:
        return ended
    result, whole = job.brought_back(ended.result)
    for at in whole if outputs else ():
        try:
            outputs[at].keep()
        except MakeupVideoError as error:
            result = job.without(result, at, error)
    return Ended(result)


class _SentFiles:
    """Puts inputs into the cluster's object store. The last one stays there, for other jobs."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last: tuple[str, list[Any]] = "", []

    def pieces_of(self, path: str, check: Callable[[], None]) -> list[Any]:
        """References to the pieces of a file. Raises InputError.

        check: called before each piece; what it raises ends the reading.
        """
        with self._lock:
            check()
            if self._last[0] != path:
                references = []
                with local_file(path).open("rb") as file:
                    for data in _pieces(file):
                        check()
                        references.append(ray.put(data))
                self._last = path, references
            return self._last[1]


class _Arriving:
    """An output whose pieces arrive from another machine; removed when it is not kept."""

    def __init__(self, output: str, job: RemoteJob, stack: ExitStack) -> None:
        self._path = Path(output)
        overwrite = job.settings.overwrite
        self._target = OutputFile(self._path, Path(job.source), overwrite=overwrite)
        stack.callback(self._target.discard)
        self._error: MakeupVideoError | None = None

    def append(self, data: bytes) -> None:
        """Write a piece, unless one before it could not be written."""
        if self._error is None:
            try:
                with write_errors(self._path), self._target.own_path.open("ab") as file:
                    file.write(data)
            except MakeupVideoError as error:  # of this output alone
                self._error = error

    def keep(self) -> None:
        """Give the output its name. Raises the error of a piece that could not be written, too."""
        if self._error is not None:
            raise self._error
        self._target.keep()


def _pieces(file: Any) -> Iterator[bytes]:
    while data := file.read(_PIECE_BYTES):
        yield data


def _on_machine(task: Any, job: RemoteJob, pieces: Sequence[Any] | None) -> Iterator[Any]:
    """Runs on a machine of the cluster: yields progress, pieces of files, and the end."""
    if pieces is None:
        yield from _performed(task, job)
        return
    with TemporaryDirectory(prefix="makeup-video-") as folder:
        here = received(job, Path(folder), pieces)
        for message in _performed(task, here):
            if isinstance(message, Ended):
                yield from _outputs_of(message, job, here)
                _name_inputs(message, str(here.source), str(job.source))
            yield message


def _outputs_of(ended: Ended, job: RemoteJob, here: RemoteJob) -> "Iterator[_Piece]":
    """The whole outputs of a job in pieces.  here: the same job on files of this machine."""
    if ended.error is not None:
        return
    _, whole = job.brought_back(ended.result)
    for at in whole:
        with open(here.outputs[at], "rb") as file:
            yield from (_Piece(at, data) for data in _pieces(file))


# Ray's own retries would repeat the progress that was reported already.
_TASK: Any = ray.remote(
    max_retries=0, scheduling_strategy="SPREAD", _generator_backpressure_num_objects=16
)(_on_machine)


def received(job: RemoteJob, folder: Path, pieces: Sequence[Any]) -> RemoteJob:
    """The same job on files of a folder of this machine, once the input has arrived."""
    source = folder / "in" / Path(job.source).name
    source.parent.mkdir()
    with source.open("wb") as file:
        for piece in pieces:
            file.write(ray.get(piece))
    outputs = []
    for number, output in enumerate(job.outputs):
        place = folder / f"out-{number}" / Path(output).name
        place.parent.mkdir()
        outputs.append(str(place))
    return job.moved(str(source), outputs)


def _name_inputs(ended: Ended, here: str, source: str) -> None:
    """Let errors name the user's input in place of its copy on this machine."""
    results = ended.result if isinstance(ended.result, list) else []
    for error in (ended.error, *(getattr(one, "error", None) for one in results)):
        if error is not None:
            error.replace(here, source)


def _performed(task: Any, job: Any) -> Iterator[Any]:
    """What the task reports while it does the job in another thread, then what it ended with."""
    messages: SimpleQueue[Any] = SimpleQueue()
    threading.Thread(
        target=lambda: messages.put(perform(task, job, messages.put)), daemon=True
    ).start()
    while True:
        message = messages.get()
        yield message
        if isinstance(message, Ended):
            return
