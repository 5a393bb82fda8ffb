"""Names as seen from a folder, with a stand-in for the drives of Windows."""

import os
from pathlib import Path

import pytest
from makeup_video.pipeline.files.relative import seen_from


def elsewhere(path, start):
    raise ValueError(f"path is on mount 'D:', start on mount {start!r}")


def test_a_file_is_named_from_the_folder(tmp_path):
    assert seen_from(tmp_path / "a", str(tmp_path / "b/c.mp4")) == Path(os.pardir, "b", "c.mp4")


@pytest.mark.parametrize("file", ["c.mp4", "./c.mp4"])
def test_a_file_on_another_drive_has_its_full_path(monkeypatch, tmp_path, file):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(os.path, "relpath", elsewhere)
    assert seen_from(Path("a"), file) == tmp_path / "c.mp4"
