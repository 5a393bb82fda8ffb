"""A thread of low priority for slow jobs, and one for cameras and recordings."""

import asyncio
import os
import sys
import threading
from pathlib import Path

import pytest
from makeup_video.pipeline import StoppedError
from makeup_video.web import slow_jobs
from makeup_video.web.slow_jobs import SlowJobs

on_linux = pytest.mark.skipif(
    sys.platform != "linux", reason="priority is a matter of threads on Linux alone"
)


def test_only_the_server_and_the_slow_jobs_use_threads():
    web = Path(slow_jobs.__file__).parent
    users = {path.name for path in web.glob("*.py") if "threading" in path.read_text()}
    locks = {"live_session.py", "preview_sink.py"}  # no more than a lock
    assert users == {"server.py", "slow_jobs.py"} | locks


def test_jobs_run_one_after_another_on_a_thread_of_their_own():
    one_thread = SlowJobs()
    futures = [one_thread.submit(threading.get_native_id) for _ in range(5)]
    (only,) = {future.result(20) for future in futures}
    assert only != threading.get_native_id()


@on_linux
def test_slow_jobs_have_lower_priority_than_other_threads():
    def priority():
        return os.getpriority(os.PRIO_PROCESS, threading.get_native_id())

    assert SlowJobs().submit(priority).result(20) > priority()


@on_linux
def test_threads_of_a_recording_keep_the_usual_priority():
    def priority_of_a_thread():
        found = []

        def read():
            found.append(os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))

        thread = threading.Thread(target=read)  # inherits the priority of the one that starts it
        thread.start()
        thread.join(20)
        return found[0]

    usual = os.getpriority(os.PRIO_PROCESS, threading.get_native_id())
    assert asyncio.run(SlowJobs().run_on_device(priority_of_a_thread)) == usual


def test_a_recording_does_not_wait_for_a_photo():
    slow_jobs, go_on = SlowJobs(), threading.Event()
    photo = slow_jobs.submit(lambda: go_on.wait(20))
    assert asyncio.run(slow_jobs.run_on_device(lambda: not photo.done()))
    go_on.set()
    assert photo.result(20)


@pytest.mark.parametrize("run", [SlowJobs.run, SlowJobs.run_on_device])
def test_the_result_or_error_of_a_job_reaches_its_waiter(run):
    async def waiting():
        slow_jobs = SlowJobs()
        assert await run(slow_jobs, lambda: 3) == 3
        with pytest.raises(ZeroDivisionError):
            await run(slow_jobs, lambda: 1 // 0)

    asyncio.run(waiting())


def test_waiting_jobs_are_cancelled_by_a_stop():
    slow_jobs, go_on, done = SlowJobs(), threading.Event(), []
    first = slow_jobs.submit(lambda: go_on.wait(20))
    second = slow_jobs.submit(lambda: done.append(1))
    slow_jobs.stop()
    go_on.set()
    assert first.result(20) and second.cancelled() and not done


def test_after_the_end_jobs_are_left_out_and_say_so():
    slow_jobs = SlowJobs()
    slow_jobs.stop()
    assert slow_jobs.submit(lambda: pytest.fail("it ran")).cancelled()
    for run in (slow_jobs.run, slow_jobs.run_on_device):
        with pytest.raises(StoppedError, match="stopping"):
            asyncio.run(run(lambda: 1))
