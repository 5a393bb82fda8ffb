"""What holds for all tests."""

import signal

import browser
from hypothesis import settings

# No test depends on the machine's speed: one that has other things to do takes a second for what
# takes 10 ms.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

# A job in the background may be started with Ctrl-C ignored, and would hand that on: the tests of
# Ctrl-C would then wait for ever.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_terminal_summary(terminalreporter):
    """A test that was left out is told of, without any option."""
    skipped = terminalreporter.stats.get("skipped", [])
    left_out = sum(browser.LEFT_OUT in str(report.longrepr) for report in skipped)
    if left_out:
        terminalreporter.write_line(f"left out: {left_out} tests of the page, {browser.LEFT_OUT}")
