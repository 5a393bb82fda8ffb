"""One thread of low priority for slow jobs."""

import asyncio
import os
import sys
import threading
from pathlib import Path

import pytest
from makeup_video.pipeline import StoppedError
from makeup_video.web import slow_jobs
from makeup_video.web.slow_jobs import SlowJobs


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


@pytest.mark.skipif(
    sys.platform != "linux", reason="priority is a matter of threads on Linux alone"
)
def test_slow_jobs_have_lower_priority_than_other_threads():
    def priority():
        return os.getpriority(os.PRIO_PROCESS, threading.get_native_id())

    assert SlowJobs().submit(priority).result(20) > priority()


def test_the_result_or_error_of_a_job_reaches_its_waiter():
    async def waiting():
        slow_jobs = SlowJobs()
        assert await slow_jobs.run(lambda: 3) == 3
        with pytest.raises(ZeroDivisionError):
            await slow_jobs.run(lambda: 1 // 0)

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
    with pytest.raises(StoppedError, match="stopping"):
        asyncio.run(slow_jobs.run(lambda: 1))
