"""Settings for all tests."""

import os
import signal

import browser
import pytest
from hypothesis import settings

# No test depends on the machine's speed: a busy machine may take a second for 10 ms of work. And
# the same tree passes or fails every time; `--hypothesis-profile random` draws new examples.
settings.register_profile("same", deadline=None, derandomize=True)
settings.register_profile("random", deadline=None)
settings.load_profile("same")

# A background job may start with SIGINT ignored, and one under nohup with SIGHUP; child processes
# inherit that. The tests of these signals would then wait forever.
signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP"):
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.fixture(autouse=True)
def same_scheduling():
    """A test that left a real-time policy behind would starve the tests after it."""
    scheduler = getattr(os, "sched_getscheduler", lambda _: None)
    before = scheduler(0)
    yield
    assert scheduler(0) == before


def pytest_terminal_summary(terminalreporter):
    """Report skipped tests of the page, without any option of pytest."""
    skipped = terminalreporter.stats.get("skipped", [])
    left_out = sum(browser.LEFT_OUT in str(report.longrepr) for report in skipped)
    if left_out:
        terminalreporter.write_line(f"left out: {left_out} tests of the page, {browser.LEFT_OUT}")
