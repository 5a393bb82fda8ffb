"""The journal of a batch: what was begun, done and failed, in a file that survives a kill.

Each line is one JSON object. Lines are only ever appended, and are on the disk before the batch
goes on:

    {"event": "begun", "output": "talk-nude.mp4", "key": "5d0e...", "was": null}
    {"event": "done", "output": "talk-nude.mp4", "key": "5d0e...", "size": 1234567, ...}
    {"event": "failed", "output": "talk-plum.mp4", "key": "81c2...", "kind": "OutputError", ...}

The last line about an output counts. A line that a kill cut short is removed when the file is
opened.
"""

import base64
import contextlib
import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import IO, Any, Self

from makeup_video.pipeline import errors
from makeup_video.pipeline.batch.job import Done, Failed, Identity, Job, JobLook
from makeup_video.pipeline.errors import MakeupVideoError, UsageError, option
from makeup_video.pipeline.files.output_file import write_errors
from makeup_video.pipeline.files.part_file import lock_file
from makeup_video.pipeline.files.relative import seen_from

_BEGINS = b'{"event": "'
# What a line of each event holds, beside the output and its key.
_HELD = {
    "begun": {"was"},
    "done": {name for name in Done._fields if name != "output"},
    "failed": {"kind", "error"},
}
_NOT_OF_THE_RESULT = ("overwrite", "observe", "on_whole")  # settings that change no output
Entry = dict[str, Any]


class Journal:
    """The journal file of a batch, locked while it is open.

    Raises UsageError when another batch has it open, or when it is not a journal or not an ordinary
    file; OutputError when it cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with write_errors(path):
            self._is_new = not path.exists()
            if not self._is_new and not path.is_file():
                raise UsageError(
                    f"{path} is no ordinary file: give {option('journal')} another name"
                )
            self._file: IO[bytes] = path.open("a+b")
            if not lock_file(self._file.fileno()):
                self._file.close()
                raise UsageError(f"another batch is writing {path}: wait for it to end")
        self._entries: dict[str, Entry] = {}
        self._begun: dict[str, str] = {}  # keys of outputs, made before their inputs were read
        try:
            self._read()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def close(self) -> None:
        """Let another batch open the journal. A new journal without a line is removed."""
        if self._is_new and not os.fstat(self._file.fileno()).st_size:
            self.path.unlink(missing_ok=True)
        with contextlib.suppress(OSError):  # about a line that a full disk refused already
            self._file.close()

    def entry(self, job: Job, look: JobLook) -> Entry | None:
        """The last line about an output, unless it is about another look or another input."""
        entry = self._entries.get(self._name(look.output))
        return entry if entry is not None and entry["key"] == self._key(job, look) else None

    def finished(self, job: Job, look: JobLook) -> Entry | None:
        """The last line about an output, if it says that the same work is done, whatever the size
        and time of its input. For an input that is gone."""
        entry = self._entries.get(self._name(look.output))
        if entry is None or entry["event"] != "done":
            return None
        return entry if entry.get("work") == self._work(job, look) else None

    def knows(self, output: str) -> bool:
        """True for an output that the batch has begun to write, whatever its look and input."""
        return self._name(output) in self._entries

    @property
    def outputs(self) -> list[Path]:
        """Every file that the batch has begun to write."""
        return [self.path.parent / name for name in self._entries]

    def begin(self, job: Job) -> Job:
        """Note that work on a job's outputs begins, and which files have their names now.

        Returns the job with these files in `was`.
        """
        was = tuple(identity(one.output) for one in job.looks)
        self._begun |= {one.output: self._key(job, one) for one in job.looks}
        lines = [
            {"event": "begun", "output": self._name(one.output), "key": self._begun[one.output],
             "was": before}
            for one, before in zip(job.looks, was, strict=True)
        ]  # fmt: skip
        self._append(lines)
        return replace(job, was=was)

    def end(self, job: Job, results: Sequence[Done | Failed]) -> list[Done | Failed]:
        """Note what became of the outputs of a job, once their files are on the disk.

        Returns what was noted: an output whose file does not get onto the disk counts as failed.
        """
        # keys from before painting: an input may have been replaced meanwhile
        keys = {one.output: self._begun.get(one.output) or self._key(job, one) for one in job.looks}
        results = [_to_disk(one) if isinstance(one, Done) else one for one in results]
        works = {one.output: self._work(job, one) for one in job.looks}
        lines = [
            {**_values(one), "key": keys[one.output], "work": works[one.output]} for one in results
        ]
        self._append([{**line, "output": self._name(line["output"])} for line in lines])
        return results

    def _key(self, job: Job, look: JobLook) -> str:
        return key_of(job, look, self._name(job.source))

    def _work(self, job: Job, look: JobLook) -> str:
        return key_of(job, look, self._name(job.source), with_state=False)

    def _name(self, file: str) -> str:
        """A file as lines name it: relative to the journal, so that a folder can be moved."""
        return seen_from(self.path.absolute().parent, file).as_posix()

    def _append(self, lines: list[Entry]) -> None:
        text = "".join(json.dumps(line) + "\n" for line in lines)
        with write_errors(self.path):
            self._file.write(text.encode())
            self._file.flush()
            os.fsync(self._file.fileno())
        for line in lines:
            self._entries[line["output"]] = line

    def _read(self) -> None:
        self._file.seek(0)
        data = self._file.read()
        whole = data.rfind(b"\n") + 1
        for number, line in enumerate(data[:whole].splitlines(), 1):
            if not line.strip():
                continue
            entry = _entry(line)
            if entry is None:
                raise self._is_no_journal(number)
            self._entries[entry["output"]] = entry
        if rest := data[whole:]:
            begun = rest.rstrip(b"\0")  # zeros: what some file systems leave after a crash
            if not begun.startswith(_BEGINS[: len(begun)]):  # another file, which stays as it is
                raise self._is_no_journal(data.count(b"\n") + 1)
            with write_errors(self.path):
                self._file.truncate(whole)

    def _is_no_journal(self, line: int) -> UsageError:
        return UsageError(
            f"{self.path}, line {line}, is no line of a batch's journal: give "
            f"{option('journal')} another name"
        )


def key_of(job: Job, look: JobLook, name: str, *, with_state: bool = True) -> str:
    """A hash of all that an output depends on: the input, the look, the settings.

    name: the input's name in the journal.  with_state: the input's size and time count, too.
    """
    source: list[str | int] = [name]
    # there may be no such file, or the name may be one that no file can have
    if with_state and (state := identity(job.source)) is not None:
        source += state[1:]
    settings = {
        field.name: str(getattr(job.settings, field.name))
        for field in fields(job.settings)
        if field.name not in _NOT_OF_THE_RESULT
    }
    text = json.dumps([source, look.look.to_dict(), settings], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def identity(path: str) -> Identity | None:
    """The identity of a file; None where there is no file."""
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return None
    return status.st_ino, status.st_size, status.st_mtime_ns


def result_of(output: str, entry: Entry) -> Done | Failed:
    """The result that a line of `end` was made from; output: its path now."""
    if entry["event"] == "failed":
        kind = getattr(errors, str(entry["kind"]), MakeupVideoError)
        return Failed(output, kind(entry["error"]))
    before, after = (_bytes(entry[name]) for name in ("before", "after"))
    size, frames, seconds = entry["size"], entry["frames"], entry["seconds"]
    return Done(
        output, size, frames, seconds, tuple(entry["warnings"]), entry["damaged"], before, after
    )


def _values(result: Done | Failed) -> Entry:
    """What a line of `end` holds of a result."""
    if isinstance(result, Failed):
        kind, text = type(result.error).__name__, result.error.marked
        return {"event": "failed", "output": result.output, "kind": kind, "error": text}
    values = result._asdict()
    values["before"], values["after"] = map(_text, (result.before, result.after))
    return {"event": "done", **values}


def _text(data: bytes | None) -> str | None:
    return None if data is None else base64.b64encode(data).decode()


def _bytes(text: str | None) -> bytes | None:
    return None if text is None else base64.b64decode(text)


def _entry(line: bytes) -> Entry | None:
    """The object of a line; None for anything that no journal holds."""
    try:
        entry = json.loads(line)
    except ValueError:
        return None
    if not isinstance(entry, dict):
        return None
    texts = [entry.get(name) for name in ("event", "output", "key")]
    if not all(isinstance(text, str) for text in texts) or texts[0] not in _HELD:
        return None
    return entry if _HELD[entry["event"]] <= entry.keys() else None


def _to_disk(done: Done) -> Done | Failed:
    """Wait until a file and its name are on the disk. A whole file that has been moved is fine."""
    path = Path(done.output)
    try:
        with write_errors(path), contextlib.suppress(FileNotFoundError):
            for place in (path,) if os.name == "nt" else (path, path.parent):
                number = os.open(place, os.O_RDONLY)
                try:
                    os.fsync(number)
                finally:
                    os.close(number)
    except MakeupVideoError as error:
        return Failed(done.output, error)
    return done
