"""Jobs in processes of their own: results in order, the first error, a killed process, a stop."""

import os
import signal
import time
from pathlib import Path

import process_tasks
import pytest
from makeup_video.pipeline import OutputError, StoppedError, WorkerError
from makeup_video.pipeline.engine.processes import Processes


def test_results_come_in_the_order_of_the_jobs():
    ticks = []
    results = Processes(process_tasks.square, 2).run(range(5), ticks.append)
    assert [value for value, _ in results] == [0, 1, 4, 9, 16]
    assert ticks == sorted(ticks) and ticks[-1] == 10
    assert os.getpid() not in {process for _, process in results}


def test_a_job_can_wait_for_the_result_before_it():
    follow = Processes(process_tasks.square, 4, lambda job, before: job + before[0])
    assert [value for value, _ in follow.run([2, 1, 1], lambda _: None)] == [4, 25, 676]


def test_the_first_error_ends_all_jobs():
    with pytest.raises(OutputError, match="no room"):
        Processes(process_tasks.refuse, 2).run([0, 1], lambda _: None)


def test_a_killed_process_is_one_line():
    with pytest.raises(WorkerError, match="was killed") as caught:
        Processes(process_tasks.die, 1).run([0], lambda _: None)
    assert len(str(caught.value).splitlines()) == 1


def test_ctrl_c_stops_all_jobs():
    def interrupt(_):
        raise KeyboardInterrupt

    with pytest.raises(StoppedError):
        Processes(process_tasks.refuse, 2).run([0, 2], interrupt)


def test_workers_leave_stop_signals_to_the_main_process():
    assert Processes(process_tasks.ignore_stop_signals, 1).run([0], lambda _: None) == ["alive"]


def test_no_worker_outlives_the_main_process(tmp_path):
    """Its next job would never come."""
    note = tmp_path / "worker"
    if os.fork() == 0:
        try:
            Processes(process_tasks.wait_for_ever, 1).run([note], lambda _: None)
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
