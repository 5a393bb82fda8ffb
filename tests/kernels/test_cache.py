"""Compiled kernels are cached where the disk has room, and nothing else is left there."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from makeup_video.kernels import cache
from makeup_video.kernels.cache import NoRoomError, give_back, left_clean, settle, why_not_kept

DAY = 86400


@pytest.fixture(autouse=True)
def places(monkeypatch, tmp_path):
    """Restores the environment, and makes temporary folders below tmp_path."""
    monkeypatch.setenv("POCL_CACHE_DIR", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    yield
    give_back()


def own_folders(tmp_path):
    return list((tmp_path / "temporary").glob("makeup-video-*"))


def test_the_folder_is_the_one_that_pocl_would_choose(monkeypatch, tmp_path):
    assert settle() == tmp_path / "xdg/pocl/kcache"
    assert os.environ["POCL_CACHE_DIR"] == str(tmp_path / "xdg/pocl/kcache")
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path / "given"))
    assert settle() == tmp_path / "given"
    assert own_folders(tmp_path) == []
    assert list((tmp_path / "given").iterdir()) == []  # the trial leaves nothing


@pytest.mark.parametrize("variable", ["XDG_CACHE_HOME", "POCL_CACHE_DIR"])
def test_a_temporary_folder_replaces_one_that_cannot_be_made(monkeypatch, tmp_path, variable):
    (tmp_path / "file").touch()
    monkeypatch.setenv(variable, str(tmp_path / "file" / "below"))
    folder = settle()
    assert own_folders(tmp_path) == [folder] and folder.stat().st_mode & 0o777 == 0o700
    reason = f"{tmp_path / 'file' / 'below'}"
    assert why_not_kept().startswith(reason) and "Not a directory" in why_not_kept()
    assert settle() == folder and why_not_kept().startswith(reason)  # for the next device, too
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path / "kept"))
    assert settle() == tmp_path / "kept" and why_not_kept() is None
    monkeypatch.setenv("POCL_CACHE_DIR", str(folder))
    assert settle() == folder
    assert os.environ["POCL_CACHE_DIR"] == str(folder)
    give_back()
    assert own_folders(tmp_path) == []


def test_without_a_home_no_folder_named_tilde_is_made(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", "~/.cache")
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert [settle()] == own_folders(tmp_path)
    assert list((tmp_path / "here").iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_forked_process_leaves_the_folder_to_its_parent(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", "~/.cache")
    folder = settle()
    if (child := os.fork()) == 0:
        give_back()
        os._exit(0)
    os.waitpid(child, 0)
    assert own_folders(tmp_path) == [folder]


def full(folder):
    raise OSError(28, "No space left on device", str(folder))


def test_a_full_disk_is_noticed_before_pocl_fails_on_it(monkeypatch, tmp_path):
    allocate = cache._allocate
    usual = tmp_path / "xdg/pocl/kcache"
    monkeypatch.setattr(
        cache, "_allocate", lambda path: (full if path == usual else allocate)(path)
    )
    assert [settle()] == own_folders(tmp_path)


@pytest.mark.parametrize(
    "state",
    [
        SimpleNamespace(f_flag=getattr(os, "ST_NOEXEC", 0), f_files=0, f_favail=0),
        SimpleNamespace(f_flag=0, f_files=1000, f_favail=3),
    ],
    ids=["may hold no programs", "no more files"],
)
def test_a_disk_that_pocl_would_fail_on_is_not_used(monkeypatch, tmp_path, state):
    statvfs = os.statvfs
    usual = tmp_path / "xdg/pocl/kcache"
    monkeypatch.setattr(os, "statvfs", lambda path: state if path == usual else statvfs(path))
    assert [settle()] == own_folders(tmp_path)


def test_a_system_that_tells_no_room_has_its_usual_folder(monkeypatch, tmp_path):
    """Windows has neither of these functions."""
    for name in ("statvfs", "posix_fallocate"):
        monkeypatch.delattr(os, name, raising=False)
    assert settle() == tmp_path / "xdg/pocl/kcache" and why_not_kept() is None


def test_no_room_anywhere_is_one_line_that_names_all_places(monkeypatch, tmp_path):
    monkeypatch.setattr(cache, "_allocate", full)
    with pytest.raises(NoRoomError, match="No space left on device") as caught:
        settle()
    message = str(caught.value)
    assert (
        "\n" not in message
        and str(tmp_path / "xdg") in message
        and str(tmp_path / "temporary") in message
    )
    assert own_folders(tmp_path) == [] and os.environ["POCL_CACHE_DIR"] == ""


def test_a_device_without_room_leaves_others_their_folder(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file" / "below"))
    first = settle()
    monkeypatch.setattr(cache, "_allocate", full)
    with pytest.raises(NoRoomError):
        settle()
    assert own_folders(tmp_path) == [first] and os.environ["POCL_CACHE_DIR"] == str(first)


def test_only_leftovers_of_pocl_are_removed(tmp_path):
    def make(name, text="", age=0):
        (tmp_path / name).write_text(text)
        os.utime(tmp_path / name, (time.time() - age,) * 2)

    make("tempfile_before")  # named like PoCL's, but not made by this run
    make("tempfile_other1")
    make("tempfile_others")
    make("tempfile_second")
    make("tempfile_aaaaaa")  # from a run that starts at the same time
    make("tempfile_bbbbbb.so.o", "x", 2 * DAY)
    make("tempfile_cccccc", "", 2 * DAY)
    make("notes", "", 2 * DAY)
    with left_clean(tmp_path):
        make("tempfile_dddddd")
        make("tempfile_eeeeee.cl", "in use")
        make("tempfile_ffffff", "in use")
    remaining = {path.name for path in tmp_path.iterdir() if path.is_file()}
    assert remaining == {
        "tempfile_before", "tempfile_other1", "tempfile_others", "tempfile_second", "tempfile_aaaaaa",
        "notes", "tempfile_eeeeee.cl", "tempfile_ffffff",
    }  # fmt: skip


def test_a_process_that_paints_leaves_only_kernels_behind(tmp_path):
    code = (
        "import numpy as np; from makeup_video.kernels.program import Device\n"
        "device = Device(); plane = device.memory((1, 16), np.uint8)\n"
        "program = device.build('__kernel void one(__global uchar *p) { p[0] = 1; }', 13)\n"
        "plane.array[:] = 0; plane.send()\n"
        "device.launch(program.one, (16, 1), [plane.buffer]); plane.fetch(); device.finish()\n"
        "assert plane.array[0, 0] == 1"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "new")}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
    left = [path for path in (tmp_path / "new").rglob("*") if path.is_file()]
    assert {path.name for path in left} == {"program.bc", "last_accessed", "one.so"}


def test_kernels_are_built_though_their_folder_was_removed(tmp_path):
    code = (
        "import os, shutil; from makeup_video.kernels.program import Device\n"
        "device = Device(); shutil.rmtree(os.environ['POCL_CACHE_DIR'])\n"
        "device.build('__kernel void one(__global uchar *p) { p[0] = 1; }', 13)"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "new")}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
    assert list((tmp_path / "new").rglob("program.bc"))


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may mount a small file system")
@pytest.mark.parametrize(
    "options", ["size=64k", "size=1m", "size=9m,noexec", "size=9m,nr_inodes=5"]
)
def test_a_really_small_disk_is_not_used(tmp_path, options):
    small = tmp_path / "small"
    small.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", options, "none", str(small)]
    if subprocess.run(words, check=False).returncode:
        pytest.skip("mounting is not allowed here; the tests above fake it")
    try:
        os.environ["POCL_CACHE_DIR"] = str(small)
        assert [settle()] == own_folders(tmp_path)
        assert list(Path(small).iterdir()) == []
    finally:
        subprocess.run(["umount", str(small)], check=True)
