"""Jobs in processes: a crash, a bad video or a full folder ends one job, Ctrl-C ends them all."""

import os
import signal
from dataclasses import replace
from multiprocessing import active_children

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import (
    InputError,
    Look,
    Settings,
    StoppedError,
    TooLittleMemoryError,
    UsageError,
    WorkerError,
    product,
)
from makeup_video.pipeline.batch.job import Done, Failed, Job, JobLook
from makeup_video.pipeline.batch.journal import Journal
from makeup_video.pipeline.batch.run import local_workers, run_batch
from makeup_video.pipeline.batch.task import run_job
from makeup_video.pipeline.engine.processes import ChildProcess
from makeup_video.pipeline.images import picture_size
from media import make_clip
from people import SAMPLES, clip, write_video
from process_tasks import process_id

BARE = Look()
BERRY = Look(lips=product((120, 10, 60), "satin"))


class Heard:
    """Records what a batch reports, and calls on_progress at every progress report."""

    def __init__(self, on_progress=lambda: None):
        self.frames, self.order, self._on_progress = [], [], on_progress

    def progress(self, job, progress):
        self.frames.append((job.source, progress.looks, progress.frames))
        self._on_progress()

    def ended(self, job, results):
        self.order.append([one.output for one in results])


def job_of(source, *names, look=BARE):
    folder = os.path.dirname(source)
    end = os.path.splitext(source)[1]
    stem = os.path.basename(source).removesuffix(end)
    looks = (JobLook(name, look, f"{folder}/{stem}-{name}{end}") for name in names)
    return Job(str(source), tuple(looks), Settings(preset="ultrafast"))


@pytest.mark.parametrize("at_once", [1, 2])
def test_every_job_is_done_and_a_bad_one_fails_alone(tmp_path, at_once):
    sources = [make_clip(tmp_path / f"{name}.mp4") for name in "abc"]
    (tmp_path / "b.mp4").write_text("no video")
    jobs = [job_of(source, "one", "two") for source in map(str, sources)]
    heard = Heard()
    with Journal(tmp_path / "j.jsonl") as journal:
        results = run_batch(jobs, journal, heard, local_workers(at_once))
    assert sorted(results) == sorted(look.output for job in jobs for look in job.looks)
    for output, result in results.items():
        if "/b-" in output:
            assert isinstance(result.error, InputError)
        else:
            assert (result.frames, result.size) == (12, os.stat(output).st_size)
    assert sorted(heard.order) == [[look.output for look in job.looks] for job in jobs]
    assert not active_children()


def test_a_process_that_dies_ends_its_job_alone(tmp_path):
    long = write_video(tmp_path / "long.mkv", clip(40) * 6)  # must not end before the kill
    short = make_clip(tmp_path / "short.mp4")
    worker = ChildProcess()
    killed = []

    def kill():
        if not killed:
            killed.append(process_id(worker))
            os.kill(killed[0], signal.SIGKILL)

    jobs = [job_of(str(long), "a", look=BERRY), job_of(str(short), "b")]
    with Journal(tmp_path / "j.jsonl") as journal:
        results = run_batch(jobs, journal, Heard(kill), [worker])
    dead, alive = (results[job.looks[0].output] for job in jobs)
    assert isinstance(dead, Failed) and isinstance(dead.error, WorkerError)
    assert "was ended by SIGKILL" in str(dead.error)
    assert isinstance(alive, Done)
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "j.jsonl", "long.mkv", "short-b.mp4", "short.mp4",
    ]  # fmt: skip


@pytest.mark.parametrize("error", [WorkerError, TooLittleMemoryError])
def test_what_was_whole_when_a_job_was_cut_short_is_kept(tmp_path, error):
    class Fails:
        per_machine = None

        def run(self, task, job, report):
            run_job(job.only({job.outputs[0]}), report)
            raise error("no memory")

        def stop(self):
            pass

    job = job_of(str(make_clip(tmp_path / "in.mp4")), "a", "b")
    with Journal(tmp_path / "j.jsonl") as journal:
        whole, lost = run_batch([job], journal, Heard(), [Fails()]).values()
    assert isinstance(whole, Done) and isinstance(lost.error, error)


def test_ctrl_c_ends_all_jobs_and_leaves_no_part(tmp_path):
    def interrupt():
        raise KeyboardInterrupt

    jobs = [job_of(str(write_video(tmp_path / f"{name}.mkv", clip(40))), "a", look=BERRY)
            for name in "ab"]  # fmt: skip
    with Journal(tmp_path / "j.jsonl") as journal, pytest.raises(StoppedError):
        run_batch(jobs, journal, Heard(interrupt), local_workers(2))
    assert not active_children()
    assert not list(tmp_path.glob("*.part.*"))


def test_results_in_a_process_are_those_of_run_job(tmp_path):
    job = job_of(str(write_video(tmp_path / "a.mkv", clip(30))), "x", look=BERRY)
    worker, seen = ChildProcess(), []
    try:
        (there,) = worker.run(run_job, job, seen.append)
    finally:
        worker.stop()
    os.unlink(there.output)
    (here,) = run_job(job, lambda progress: None)
    assert there._replace(seconds=0, size=0) == here._replace(seconds=0, size=0)
    assert there.frames == 30 and there.before and there.after
    assert {one.looks for one in seen} == {("x",)}


def test_looks_of_one_input_share_its_small_picture(tmp_path):
    source = tmp_path / "a.jpg"
    source.write_bytes((SAMPLES / "portrait.jpg").read_bytes())
    job = replace(job_of(str(source), "x", "y", "z"), settings=Settings())
    first, *rest = run_job(job, lambda progress: None)
    assert first.before and not any(one.before for one in rest)
    assert all(one.after for one in (first, *rest))


def test_an_output_larger_than_any_input_has_a_small_picture(tmp_path, monkeypatch):
    """A before-and-after picture has twice the pixels of the input."""
    source = tmp_path / "a.png"
    cv2.imwrite(str(source), np.full((40, 60, 3), 90, np.uint8))
    job = replace(job_of(str(source), "x"), settings=Settings(compare=True))
    monkeypatch.setattr(picture_size, "MOST_PX", 3000)
    (done,) = run_job(job, lambda progress: None)
    assert done.before and done.after


@pytest.mark.parametrize(
    ("per_machine", "workers", "jobs", "share"),
    [(None, 8, 2, 0.25), (None, 2, 8, 0.25), (4, 100, 9, 0.125), (4, 100, 1, 0.5), (8, 1, 9, 0.5)],
)
def test_jobs_share_the_memory_of_their_machine(tmp_path, per_machine, workers, jobs, share):
    shares = []

    class Noting:
        def __init__(self):
            self.per_machine = per_machine

        def run(self, task, job, report):
            shares.append(job.memory_share)
            return [Failed(one.output, UsageError("no")) for one in job.looks]

        def stop(self):
            pass

    todo = [job_of(str(tmp_path / f"{number}.mp4"), "x") for number in range(jobs)]
    with Journal(tmp_path / "j.jsonl") as journal:
        run_batch(todo, journal, Heard(), [Noting() for _ in range(workers)])
    assert shares == [share] * jobs


def test_at_least_one_worker_is_needed():
    assert len(local_workers()) >= 1
    with pytest.raises(UsageError, match="must be at least 1, got 0"):
        local_workers(0)
