"""One job of a batch, all looks of one input, and its results, as plain data."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.offline.report import size_in_words
from makeup_video.pipeline.offline.settings import Settings

# Inode, size and modification time: they tell a file from another file of the same name.
Identity = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class JobLook:
    """A look of a job: its name for messages, the look, and the file to write."""

    name: str
    look: Look
    output: str


@dataclass(frozen=True, slots=True)
class Job:
    """What to paint on one video or picture, as plain data that any process can be sent.

    looks: one or more.  settings: without callbacks and `split_minutes`.
    memory_share: the share of the free memory for encoders; see process_looks.
    was: the files that had the outputs' names when the job began; None where there was none.
    attempt: 1, and one more each time the machine that did the job was lost.
    """

    source: str
    looks: tuple[JobLook, ...]
    settings: Settings
    memory_share: float = 0.5
    was: tuple[Identity | None, ...] = ()
    attempt: int = 1

    @property
    def outputs(self) -> tuple[str, ...]:
        return tuple(one.output for one in self.looks)

    def only(self, outputs: set[str]) -> "Job":
        """Return this job for only some of its outputs."""
        kept = [at for at, one in enumerate(self.looks) if one.output in outputs]
        looks = tuple(self.looks[at] for at in kept)
        return replace(self, looks=looks, was=tuple(self.was[at] for at in kept if self.was))

    def at_full_paths(self) -> "Job":
        """Return this job for a process in another folder."""
        outputs = (replace(one, output=os.path.abspath(one.output)) for one in self.looks)
        return replace(self, source=os.path.abspath(self.source), looks=tuple(outputs))

    def again(self) -> "Job":
        """Return this job for another machine, which keeps what the lost machine has finished."""
        return replace(self, attempt=self.attempt + 1)

    def moved(self, source: str, outputs: Sequence[str]) -> "Job":
        """Return this job on other files, of which only the source exists yet."""
        looks = zip(self.looks, outputs, strict=True)
        return replace(
            self,
            source=source,
            looks=tuple(replace(one, output=output) for one, output in looks),
            was=(None,) * len(self.looks),
            attempt=1,
        )

    def brought_back(self, results: "list[Result]") -> "tuple[list[Result], list[int]]":
        """Return results under this job's own file names, and the places of whole outputs."""
        named = [one._replace(output=own) for one, own in zip(results, self.outputs, strict=True)]
        return named, [at for at, one in enumerate(named) if isinstance(one, Done)]

    def without(self, results: "list[Result]", at: int, error: MakeupVideoError) -> "list[Result]":
        """Return the results where the output at this place could not be kept."""
        failed = Failed(self.looks[at].output, error)
        return [failed if place == at else one for place, one in enumerate(results)]


class JobProgress(NamedTuple):
    """How far a job is: the names of the looks that are being painted, and their frames."""

    looks: tuple[str, ...]
    frames: int
    expected: int | None


class Done(NamedTuple):
    """An output that was written.

    size: in bytes.  before, after: JPEG files of a small picture; None where none could be made.
    Of the looks of one job only the first has `before`.
    """

    output: str
    size: int
    frames: int
    seconds: float
    warnings: tuple[str, ...]
    damaged: bool
    before: bytes | None
    after: bytes | None

    @property
    def size_in_words(self) -> str:
        """How much was written: "300 frames, 1.2 MB"."""
        size = size_in_words(self.size)
        return size if self.frames == 1 else f"{self.frames} frames, {size}"


class Failed(NamedTuple):
    """An output that was not written, and why."""

    output: str
    error: MakeupVideoError


Result = Done | Failed
