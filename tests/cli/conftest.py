"""Fixtures of the command-line tests."""

import pytest
from media import make_clip


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    make_clip(tmp_path / "in.mp4", audio="aac")
    return tmp_path


@pytest.fixture(scope="session")
def long_clip(tmp_path_factory):
    """Many small frames: a part file soon has some of them, long before the run ends."""
    return make_clip(
        tmp_path_factory.mktemp("long") / "long.mp4", frames=1600, size_wh=(256, 144), audio="aac"
    )
