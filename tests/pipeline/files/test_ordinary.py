"""Only ordinary files within a size limit are read: reading neither blocks nor fills memory."""

import os
import tracemalloc

import pytest
from makeup_video.pipeline.files.ordinary import open_ordinary, read_ordinary


def test_a_file_within_the_limit_is_read_whole(tmp_path):
    (tmp_path / "a").write_bytes(b"x" * 10)
    assert read_ordinary(tmp_path / "a", 10) == b"x" * 10
    with open_ordinary(str(tmp_path / "a"), 10) as file:
        assert file.read(3) == b"xxx"


@pytest.mark.parametrize(
    ("name", "words"),
    [("pipe", "it is no ordinary file"), ("/dev/zero", "it is no ordinary file"),
     (".", "Is a directory"), ("none", "No such file"), ("a\0b", "no file has such a name"),
     ("x" * 300, "File name too long"), ("link", "it is no ordinary file"),
     ("hole", "it has more than 1 MB")],
)  # fmt: skip
def test_anything_but_an_ordinary_file_is_refused(tmp_path, name, words):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    with (tmp_path / "hole").open("wb") as file:
        file.truncate(3_000_000_000)
    for read in (open_ordinary, read_ordinary):
        with pytest.raises(OSError) as caught:
            read(tmp_path / name, 1_000_000)
        assert words in caught.value.strerror


def test_a_file_that_grows_while_it_is_read_is_refused(tmp_path, monkeypatch):
    (tmp_path / "a").write_bytes(b"x" * 10)
    original = os.fdopen

    def grow_and_open(fd, mode):
        with (tmp_path / "a").open("ab") as file:
            file.write(b"x")
        return original(fd, mode)

    monkeypatch.setattr(os, "fdopen", grow_and_open)
    with pytest.raises(OSError, match="more than"):
        read_ordinary(tmp_path / "a", 10)


def test_a_small_file_takes_little_memory(tmp_path):
    path = tmp_path / "small"
    path.write_bytes(b"x" * 1000)
    tracemalloc.start()
    try:
        assert len(read_ordinary(path, 1_000_000_000)) == 1000
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()
