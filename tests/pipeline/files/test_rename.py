"""A file that appears during the run is never replaced, whatever the file system supports."""

import ctypes
import errno
import os

import pytest
from makeup_video.pipeline import Settings, UsageError, process_video
from makeup_video.pipeline.files import rename
from makeup_video.pipeline.files.rename import rename_new
from media import decoded, make_clip
from writers import WRITERS


def unsupported(*_args, **_settings):
    raise OSError(errno.EOPNOTSUPP, os.strerror(errno.EOPNOTSUPP))


@pytest.fixture(params=["renameat2", "link", "check"])
def method(request, monkeypatch):
    """The preferred method among those that the file system supports."""
    if request.param != "renameat2":
        monkeypatch.setattr(rename, "_by_system", unsupported)
    if request.param == "check":
        monkeypatch.setattr(os, "link", unsupported)
    return request.param


@pytest.fixture(params=["file", "folder", "broken link"])
def taken(request, tmp_path):
    path = tmp_path / "new"
    if request.param == "file":
        path.write_text("precious")
    elif request.param == "folder":
        path.mkdir()
    else:
        path.symlink_to("nowhere")
    return path


def test_a_file_is_renamed_to_a_free_name(tmp_path, method):
    (tmp_path / "old").write_text("whole")
    rename_new(tmp_path / "old", tmp_path / "new")
    assert [path.name for path in tmp_path.iterdir()] == ["new"]
    assert (tmp_path / "new").read_text() == "whole"


def test_a_name_that_is_taken_is_refused(tmp_path, method, taken):
    (tmp_path / "old").write_text("whole")
    before = taken.lstat()
    with pytest.raises(FileExistsError):
        rename_new(tmp_path / "old", taken)
    assert os.path.samestat(taken.lstat(), before)
    assert (tmp_path / "old").read_text() == "whole"


def test_other_errors_are_those_of_the_last_method(tmp_path, method):
    (tmp_path / "old").write_text("whole")
    with pytest.raises(FileNotFoundError):
        rename_new(tmp_path / "old", tmp_path / "no" / "new")
    assert (tmp_path / "old").exists()


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "renameat2"), reason="no renameat2 here")
def test_linux_needs_no_fallback(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "link", unsupported)
    monkeypatch.setattr(rename, "_by_looking", unsupported)
    (tmp_path / "old").write_text("whole")
    rename_new(tmp_path / "old", tmp_path / "new")
    assert (tmp_path / "new").read_text() == "whole"


@pytest.mark.parametrize(("make", "name"), WRITERS)
def test_a_file_made_during_the_run_stays_beside_the_part(tmp_path, method, make, name):
    out = tmp_path / name
    part = out.with_name(f"out.part{out.suffix}")
    with pytest.raises(UsageError) as caught:
        make(tmp_path, name, lambda: out.write_text("precious"))
    text = str(caught.value)
    assert str(out) in text and str(part) in text and "overwrite=True" in text and "\n" not in text
    assert out.read_text() == "precious" and part.stat().st_size > 10
    if name != "out.json":
        assert decoded(part)


def test_with_y_the_output_is_replaced(tmp_path):
    src = make_clip(tmp_path / "in.mp4")
    (tmp_path / "out.mp4").write_text("old")
    process_video(src, tmp_path / "out.mp4", None, Settings(overwrite=True))
    assert len(decoded(tmp_path / "out.mp4")) == 12
