"""Public functions take paths, and refuse anything else with an error that says so."""

from pathlib import Path

import numpy as np
import pytest
from makeup_video.pipeline import (
    Look,
    estimate_photo,
    inspect_video,
    look_from_photo,
    process_looks,
    process_video,
)
from makeup_video.pipeline.files.path_argument import check_path

WHERE = "must be a str or a Path, got"


class BytesPath:
    def __fspath__(self):
        return b"in.mp4"


def test_a_path_is_returned_as_text():
    for path in ("a/b", Path("a/b")):
        assert check_path("src", path) == "a/b"


@pytest.mark.parametrize(
    ("path", "words"),
    [
        (3, "int: give the name of a file"),
        (None, "NoneType: give the name"),
        (b"in.mp4", "bytes: os.fsdecode decodes it"),
        (BytesPath(), "BytesPath: os.fsdecode decodes it"),
    ],
)
def test_another_type_is_named_with_the_argument(path, words):
    with pytest.raises(TypeError, match=f"src {WHERE} {words}"):
        check_path("src", path)


CALLS = {
    "src": (process_video, inspect_video, lambda path, out: process_looks(path, {out: Look()})),
    "dst": (lambda path, out: process_video(out, path), lambda path, out: inspect_video(out, path)),
    "points": (lambda path, out: inspect_video(out, out, path),),
    "an output of looks": (lambda path, out: process_looks(out, {path: Look()}),),
    "path": (lambda path, _: Look.load(path), lambda path, _: Look().save(path)),
    "photo": (lambda path, _: look_from_photo(path),),
}


@pytest.mark.parametrize(("name", "call"), [(name, one) for name in CALLS for one in CALLS[name]])
def test_every_public_function_names_the_argument(tmp_path, name, call):
    with pytest.raises(TypeError, match=f"^{name} {WHERE} int: give the name of a file$"):
        call(3, tmp_path / "out.png")


def test_the_photo_of_an_estimate_is_a_path_or_bytes_too():
    with pytest.raises(TypeError, match=f"photo {WHERE} int: give the name of a file"):
        estimate_photo(3)


def test_an_array_is_for_estimate_look():
    with pytest.raises(TypeError, match=f"photo {WHERE} ndarray: estimate_look reads an array"):
        look_from_photo(np.zeros((9, 9, 3), np.uint8))
