"""The browser, `makeup-video demo`, and visits to its page."""

import pytest
from browser import DESK, Served, Visit, open_browser


@pytest.fixture(scope="module")
def chromium():
    with open_browser() as browser:
        yield browser


@pytest.fixture(scope="module")
def demo(chromium):
    served = Served("demo")
    yield served
    assert served.stop() == 0, served.lines


@pytest.fixture
def visit(chromium):
    """Opens pages; the test fails at its end if a page has faults."""
    visits = []

    def open_page(served, **context):
        visits.append(Visit(chromium, served.url, **(context or DESK)))
        return visits[-1]

    yield open_page
    for page in visits:
        page.context.close()
        assert not page.faults
