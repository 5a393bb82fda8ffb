"""The browser, `makeup-video demo`, and visits to its page."""

import pytest
from browser import DESK, Served, open_browser, visits


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
    with visits(chromium) as open_page:
        yield lambda served, **context: open_page(served.url, **(context or DESK))
