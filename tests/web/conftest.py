"""The browser, `makeup-video demo`, and visits to its page."""

from itertools import islice

import av
import pytest
from browser import DESK, Served, executable, open_browser, visits
from media import add_video
from people import SAMPLES


@pytest.fixture(scope="module")
def chromium():
    with open_browser() as browser:
        yield browser


@pytest.fixture(scope="session")
def demo():
    """One for all tests: each page has a session of its own there."""
    executable()  # a missing browser skips the tests before the server starts
    served = Served("demo")
    yield served
    assert served.stop() == 0, served.lines


@pytest.fixture(scope="session")
def camera_clip(tmp_path_factory):
    """Two seconds of the sample for a camera.

    A server paints it all the time: at half the size and rate that takes an eighth of the work.
    """
    path = tmp_path_factory.mktemp("camera") / "clip.mp4"
    with av.open(str(SAMPLES / "in.mp4")) as source, av.open(str(path), "w") as out:
        stream = add_video(out, size_wh=(640, 360), rate=15)
        for number, frame in enumerate(islice(source.decode(video=0), 0, 60, 2)):
            small = frame.reformat(640, 360)
            small.pts, small.time_base = number, stream.codec_context.time_base
            small.pict_type = 0  # the encoder's own choice
            out.mux(stream.encode(small))
        out.mux(stream.encode(None))
    return path


@pytest.fixture
def visit(chromium):
    """Opens pages; the test fails at its end if a page has faults."""
    with visits(chromium) as open_page:
        yield lambda served, **context: open_page(served.url, **(context or DESK))
