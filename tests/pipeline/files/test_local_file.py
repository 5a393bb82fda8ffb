"""The name of an input must be a file on this machine."""

import pytest
from makeup_video.pipeline import InputError
from makeup_video.pipeline.files.local_file import local_file
from media import make_clip


def test_a_link_to_a_file_is_a_file_and_a_dangling_one_is_not(tmp_path):
    make_clip(tmp_path / "in.mp4")
    (tmp_path / "link.mp4").symlink_to(tmp_path / "in.mp4")
    (tmp_path / "dangling.mp4").symlink_to(tmp_path / "no.mp4")
    assert local_file(tmp_path / "link.mp4")
    with pytest.raises(InputError, match="does not exist"):
        local_file(tmp_path / "dangling.mp4")


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("", "is empty"),
        ("folder", "is a folder: give one photo file"),
        ("no.jpg", "does not exist: give a photo file"),
        ("https://host/a.jpg", "is an address: give a photo file"),
        ("empty.jpg", "is empty \\(0 bytes\\)"),
        ("/dev/null", "is not an ordinary file"),
    ],
)
def test_what_is_no_file_is_refused_with_the_reason(tmp_path, monkeypatch, name, reason):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "empty.jpg").touch()
    with pytest.raises(InputError, match=reason):
        local_file(name, "photo")
