"""The journal is only appended to, survives any cut, is locked, and refuses foreign lines."""

import json
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import Look, OutputError, Settings, UsageError, product
from makeup_video.pipeline.batch.job import Done, Failed, Job, JobLook
from makeup_video.pipeline.batch.journal import Journal, identity, result_of

RED, BLUE = (Look(lips=product(rgb, "satin")) for rgb in ((180, 0, 40), (10, 30, 140)))


def job_in(folder, name="a", look=RED):
    source = folder / f"{name}.mp4"
    if not source.exists():
        source.write_bytes(b"video")
    return Job(str(source), (JobLook("red", look, str(folder / f"{name}-red.mp4")),), Settings())


def done(job, size=4):
    output = job.looks[0].output
    return Done(output, size, 30, 1.5, ("changed: é",), False, b"\xff\xd8", None)


def test_lines_are_read_back(tmp_path):
    first, second, third = (job_in(tmp_path, name) for name in "abc")
    with Journal(tmp_path / "j.jsonl") as journal:
        for job in (first, second, third):
            journal.begin(job)
        Path(first.looks[0].output).write_bytes(b"done")
        journal.end(first, [done(first)])
        failed = Failed(second.looks[0].output, OutputError("the disk is full"))
        journal.end(second, [failed])
    with Journal(tmp_path / "j.jsonl") as journal:
        entries = [journal.entry(one, one.looks[0]) for one in (first, second, third)]
        assert result_of(first.looks[0].output, entries[0]) == done(first)
        again = result_of(failed.output, entries[1])
        assert type(again.error) is OutputError and str(again.error) == "the disk is full"
        assert entries[2]["event"] == "begun" and entries[2]["was"] is None
        assert sorted(path.name for path in journal.outputs) == [
            "a-red.mp4", "b-red.mp4", "c-red.mp4",
        ]  # fmt: skip


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.data())
def test_a_file_cut_anywhere_is_a_journal_of_fewer_lines(tmp_path, data):
    path = tmp_path / "cut.jsonl"
    path.unlink(missing_ok=True)
    jobs = [job_in(tmp_path, name) for name in "abcd"]
    with Journal(path) as journal:
        for job in jobs:
            journal.begin(job)
    whole = path.read_bytes()
    cut = data.draw(st.integers(0, len(whole)))
    path.write_bytes(whole[:cut])
    kept = whole[:cut].count(b"\n")
    with Journal(path) as journal:
        known = [journal.entry(job, job.looks[0]) for job in jobs]
        assert [entry is not None for entry in known] == [True] * kept + [False] * (4 - kept)
        journal.begin(jobs[3])
    lines = path.read_bytes().splitlines()
    assert len(lines) == kept + 1 and all(json.loads(line)["event"] == "begun" for line in lines)


def test_an_entry_of_other_work_does_not_count(tmp_path):
    job = job_in(tmp_path)
    (look,) = job.looks
    with Journal(tmp_path / "j.jsonl") as journal:
        journal.begin(job)
        assert journal.entry(job, look) is not None
        other = job_in(tmp_path, look=BLUE)
        assert journal.entry(other, other.looks[0]) is None
        assert journal.entry(Job(job.source, job.looks, Settings(crf=10)), look) is None
        assert journal.entry(Job(job.source, job.looks, Settings(overwrite=True)), look)
        (tmp_path / "a.mp4").write_bytes(b"another video")
        assert journal.entry(job, look) is None and journal.knows(look.output)


def test_another_input_of_the_same_size_is_other_work(tmp_path):
    job = job_in(tmp_path)
    with Journal(tmp_path / "j.jsonl") as journal:
        journal.begin(job)
        os.utime(job.source, (1, 1))
        assert journal.entry(job, job.looks[0]) is None


def test_a_file_and_its_name_are_on_the_disk_before_the_line(tmp_path, monkeypatch):
    job, fsync, synced = job_in(tmp_path), os.fsync, []

    def noted(number):
        synced.append(os.fstat(number).st_ino)
        fsync(number)

    places = Path(job.looks[0].output), tmp_path, tmp_path / "j.jsonl"
    with Journal(places[2]) as journal:
        journal.begin(job)
        places[0].write_bytes(b"done")
        monkeypatch.setattr(os, "fsync", noted)
        journal.end(job, [done(job)])
    assert synced == [place.stat().st_ino for place in places]


def test_an_input_that_was_replaced_meanwhile_is_not_done(tmp_path):
    job = job_in(tmp_path)
    (look,) = job.looks
    with Journal(tmp_path / "j.jsonl") as journal:
        journal.begin(job)
        Path(look.output).write_bytes(b"done")
        Path(job.source).write_bytes(b"another video")
        journal.end(job, [done(job)])
        assert journal.entry(job, look) is None


def test_a_moved_folder_keeps_its_journal(tmp_path):
    old, new = tmp_path / "old", tmp_path / "new"
    old.mkdir()
    (old / "in.mp4").write_bytes(b"video")

    def job(folder):
        look = JobLook("red", RED, str(folder / "a.mp4"))
        return Job(str(folder / "in.mp4"), (look,), Settings())

    with Journal(old / "j.jsonl") as journal:
        journal.begin(job(old))
    old.rename(new)
    with Journal(new / "j.jsonl") as journal:
        moved = job(new)
        assert journal.entry(moved, moved.looks[0]) is not None


def test_a_journal_has_one_writer(tmp_path):
    with (
        Journal(tmp_path / "j.jsonl"),
        pytest.raises(UsageError, match=r"another batch is writing .*j\.jsonl"),
    ):
        Journal(tmp_path / "j.jsonl")
    Journal(tmp_path / "j.jsonl").close()
    assert not (tmp_path / "j.jsonl").exists()  # no job was begun


@pytest.mark.parametrize(
    "line",
    ["hello", "[]", '{"event": "begun"}', '{"a": 1}', '{"event": "x"}', '{"event": {"a": 1}}'],
)
@pytest.mark.parametrize("end", ["", "\n"])
def test_another_file_is_not_taken_for_a_journal(tmp_path, line, end):
    path = tmp_path / "notes.txt"
    path.write_text(line + end)
    if not end and line.startswith('{"event": "'):
        return  # this may be a journal line that was cut short
    with pytest.raises(UsageError, match=r"notes.txt, line 1, is no line of a batch's journal"):
        Journal(path)
    assert path.read_text() == line + end


@pytest.mark.parametrize("tail", [b"\n\n", b"\0" * 300, b'{"eve' + b"\0" * 300])
def test_what_a_crash_leaves_at_the_end_loses_nothing(tmp_path, tail):
    first, second = (job_in(tmp_path, name) for name in "ab")
    path = tmp_path / "j.jsonl"
    with Journal(path) as journal:
        journal.begin(first)
    with path.open("ab") as file:
        file.write(tail)
    with Journal(path) as journal:
        assert journal.entry(first, first.looks[0])["event"] == "begun"
        journal.begin(second)
    with Journal(path) as journal:
        assert len(journal.outputs) == 2


@pytest.mark.parametrize("lost", ["size", "before", "damaged"])
def test_a_line_without_all_that_it_holds_is_named(tmp_path, lost):
    job, path = job_in(tmp_path), tmp_path / "j.jsonl"
    with Journal(path) as journal:
        journal.end(job, [done(job)])
    entry = json.loads(path.read_text())
    del entry[lost]
    path.write_text(json.dumps(entry) + "\n")
    with pytest.raises(UsageError, match="line 1, is no line of a batch's journal"):
        Journal(path)


def test_an_output_that_is_moved_away_at_once_is_done(tmp_path):
    job = job_in(tmp_path)
    with Journal(tmp_path / "j.jsonl") as journal:
        assert journal.end(job, [done(job)]) == [done(job)]  # the output does not exist


def test_an_output_that_does_not_reach_the_disk_has_failed(tmp_path, monkeypatch):
    job, path = job_in(tmp_path), tmp_path / "j.jsonl"
    fsync = os.fsync

    def broken(number):
        if "red" in os.readlink(f"/proc/self/fd/{number}"):
            raise OSError(5, "Input/output error")
        fsync(number)

    Path(job.looks[0].output).write_bytes(b"done")
    if not Path("/proc/self/fd").exists():
        pytest.skip("this system does not tell the names of open files")
    monkeypatch.setattr(os, "fsync", broken)
    with Journal(path) as journal:
        (result,) = journal.end(job, [done(job)])
        assert isinstance(result, Failed) and "Input/output error" in str(result.error)
        assert journal.entry(job, job.looks[0])["event"] == "failed"


def test_identity_tells_files_of_one_name_apart(tmp_path):
    path = tmp_path / "a"
    assert identity(str(path)) is None
    path.write_bytes(b"1")
    first = identity(str(path))
    assert identity(str(path)) == first
    (tmp_path / "b").write_bytes(b"2")
    (tmp_path / "b").replace(path)
    assert identity(str(path)) != first


def test_a_name_that_no_file_can_have_is_one_line(tmp_path):
    with pytest.raises(OutputError, match="File name too long"):
        Journal(tmp_path / ("x" * 300))


def test_an_empty_file_that_was_there_stays(tmp_path):
    (tmp_path / "notes.txt").touch()
    Journal(tmp_path / "notes.txt").close()
    assert (tmp_path / "notes.txt").exists()


def test_a_journal_is_an_ordinary_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(UsageError, match="is no ordinary file: give journal another name"):
        Journal(tmp_path / "pipe")
    assert (tmp_path / "pipe").exists()
