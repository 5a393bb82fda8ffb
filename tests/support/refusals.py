"""Errors as the command prints them: options in a message have their dashes."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from makeup_video.cli.outcome import option_of_command
from makeup_video.pipeline import MakeupVideoError


@contextmanager
def refused(kind: type[MakeupVideoError], match: str) -> Iterator[None]:
    """The block must raise `kind` with a message of one line that contains `match`."""
    with pytest.raises(kind) as caught:
        yield
    line = caught.value.spelled(option_of_command)
    assert re.search(match, line), line
    assert "\n" not in line
