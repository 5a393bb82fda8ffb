"""The browser, `makeup-video demo`, and visits to its page."""

import pytest
from browser import DESK, Served, executable, open_browser, visits
from people import resized_sample


@pytest.fixture(scope="module")
def chromium():
    with open_browser() as browser:
        yield browser


@pytest.fixture(scope="session")
def demo():
    """One server for all tests: each page has a session of its own there."""
    executable()  # a missing browser skips the tests before the server starts
    served = Served("demo")
    yield served
    assert served.stop() == 0, served.lines


@pytest.fixture(scope="session")
def camera_clip(tmp_path_factory):
    """Two seconds of the sample for a camera.

    A server paints this clip all the time; half the size and rate take an eighth of the work.
    """
    path = tmp_path_factory.mktemp("camera") / "clip.mp4"
    return resized_sample(path, (640, 360), frames=30, every=2, rate=15)


@pytest.fixture
def visit(chromium):
    """Opens pages; the test fails at its end if a page has faults."""
    with visits(chromium) as open_page:
        yield lambda served, **context: open_page(served.url, **(context or DESK))
