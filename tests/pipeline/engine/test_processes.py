"""Jobs in processes of their own: results, the first error, a killed process, a stop."""

import os
import signal
import subprocess
import sys
import time
from multiprocessing import active_children
from pathlib import Path

import process_tasks
import pytest
from makeup_video.pipeline import (
    OutputError,
    StoppedError,
    TooLittleMemoryError,
    UsageError,
    WorkerError,
)
from makeup_video.pipeline.engine import processes
from makeup_video.pipeline.engine.jobs import run_jobs
from makeup_video.pipeline.engine.processes import ChildProcess


def results_of(task, jobs, count=1, attempts=1, on_progress=lambda job, value: None):
    """Return {job: its result or its error}."""
    ended, workers = {}, [ChildProcess(attempts) for _ in range(count)]
    try:
        run_jobs(task, jobs, workers, on_progress, ended.__setitem__)
    finally:
        for worker in workers:
            worker.stop()
    return ended


def test_every_job_has_its_result():
    heard = []
    results = results_of(process_tasks.square, range(5), 2, on_progress=lambda *x: heard.append(x))
    assert {job: value for job, (value, _) in results.items()} == {n: n * n for n in range(5)}
    assert sorted(heard) == [(n, n) for n in range(5)]
    assert os.getpid() not in {process for _, process in results.values()}


def test_a_job_is_taken_when_a_worker_is_free():
    taken = []

    def jobs():
        for number in range(4):
            taken.append((number, len(ended)))
            yield number

    ended, worker = {}, ChildProcess()
    run_jobs(process_tasks.square, jobs(), [worker], lambda *_: None, ended.__setitem__)
    worker.stop()
    assert taken == [(number, number) for number in range(4)]


def test_an_error_ends_its_job_alone():
    results = results_of(process_tasks.refuse_odd, range(3), 2)
    assert isinstance(results[1], OutputError) and "no room" in str(results[1])
    assert [results[0], results[2]] == [0, 2]


def test_an_error_that_is_not_ours_is_one_line():
    (error,) = results_of(process_tasks.divide, [0]).values()
    assert isinstance(error, WorkerError)
    assert str(error).startswith("internal error: ZeroDivisionError: ")
    assert "in divide" in error.__notes__[0]


def test_memory_that_runs_out_is_no_internal_error():
    for error in results_of(process_tasks.run_out_of_memory, ["", "std::bad_alloc"]).values():
        assert isinstance(error, TooLittleMemoryError)
        assert str(error).startswith("there is not enough memory for this job: lower jobs, close")


def test_what_listens_may_end_all_jobs():
    worker = ChildProcess()

    def refuse(job, outcome):
        raise outcome

    with pytest.raises(OutputError, match="no room"):
        run_jobs(process_tasks.refuse_odd, [1, 2], [worker], lambda *_: None, refuse)
    assert not Path(f"/proc/{process_tasks.process_id(worker)}").exists()


def test_a_killed_process_is_one_line():
    (error,) = results_of(process_tasks.die, [0]).values()
    assert isinstance(error, WorkerError) and "was ended by SIGKILL, perhaps" in str(error)
    assert len(str(error).splitlines()) == 1


@pytest.mark.skipif(not hasattr(signal, "SIGRTMIN"), reason="needs real-time signals")
def test_a_signal_without_a_name_is_named_by_its_number():
    number = signal.SIGRTMIN + 1
    (error,) = results_of(process_tasks.die_by, [number]).values()
    assert isinstance(error, WorkerError) and str(error).endswith(f"by signal {int(number)}")


def test_a_process_that_does_not_end_is_one_line(monkeypatch):
    monkeypatch.setattr(processes, "_SOON_SECONDS", 0)
    try:
        (error,) = results_of(process_tasks.hang_up, [0]).values()
    finally:
        for process in active_children():
            process.kill()
    assert isinstance(error, WorkerError) and str(error).endswith("stopped answering and was ended")


def test_a_job_whose_process_is_killed_is_tried_again(tmp_path):
    (result,) = results_of(process_tasks.die_twice, [tmp_path], attempts=3).values()
    assert result == 3
    (tmp_path / "attempts").unlink()
    (error,) = results_of(process_tasks.die_twice, [tmp_path], attempts=2).values()
    assert "was ended by SIGKILL, in each of 2 attempts, perhaps" in str(error)


def test_a_script_that_calls_unguarded_is_told_so_once(tmp_path):
    script = tmp_path / "unguarded.py"
    script.write_text(
        "from makeup_video.pipeline.engine.processes import ChildProcess\n"
        "open('begun', 'a').write('once ')\n"
        "ChildProcess(3).run(abs, -1, print)\n"
    )
    run = subprocess.run(
        [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert run.stderr.splitlines()[-1].endswith(
        'in a script put the call under `if __name__ == "__main__":`'
    )
    assert (tmp_path / "begun").read_text() == "once once "


def test_ctrl_c_stops_all_jobs():
    def interrupt(*_):
        raise KeyboardInterrupt

    with pytest.raises(StoppedError):
        results_of(process_tasks.go_on, [0, 2], 2, on_progress=interrupt)


def test_a_stopped_worker_does_no_job():
    worker = ChildProcess(3)
    worker.stop()
    with pytest.raises(UsageError, match="workers serve one video"):
        worker.run(process_tasks.square, 1, lambda value: None)
    worker.stop()
    assert process_tasks.process_id(worker) is None


def test_workers_leave_stop_signals_to_the_main_process():
    assert results_of(process_tasks.ignore_stop_signals, [0]) == {0: "alive"}


def test_no_worker_outlives_the_main_process(tmp_path):
    """Otherwise an orphaned worker would wait for its next job for ever."""
    note = tmp_path / "worker"
    if os.fork() == 0:
        try:
            results_of(process_tasks.wait_for_ever, [note])
        finally:
            os._exit(1)
    deadline = time.monotonic() + 60
    while not note.exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    worker, parent = map(int, note.read_text().split())
    os.kill(parent, signal.SIGKILL)
    os.waitpid(parent, 0)
    while Path(f"/proc/{worker}").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not Path(f"/proc/{worker}").exists()
