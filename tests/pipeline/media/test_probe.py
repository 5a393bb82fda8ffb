"""Short looks into a video: whether it plays, and how many frames it has."""

import pytest
from makeup_video.pipeline import InputError
from makeup_video.pipeline.media.probe import declared_frames, picture_at, plays
from media import make_clip


@pytest.mark.parametrize("name", ["a.mp4", "a.mov", "a.mkv"])
def test_a_whole_file_plays(tmp_path, name):
    path = make_clip(tmp_path / name, frames=15)
    assert plays(path) and plays(path, 15) and declared_frames(path) == 15
    if name != "a.mkv":  # Matroska's header has no frame count
        assert not plays(path, 14)


@pytest.mark.parametrize("keep", [0.0, 0.05, 0.5, 0.95])
def test_a_cut_mp4_does_not_play(tmp_path, keep):
    path = make_clip(tmp_path / "a.mp4")
    data = path.read_bytes()
    path.write_bytes(data[: round(len(data) * keep)])
    assert not plays(path)
    with pytest.raises(InputError):
        picture_at(path, 0, 1)


def test_of_a_damaged_video_the_last_good_picture_is_shown(tmp_path):
    path = make_clip(tmp_path / "a.mkv", frames=60, options={"g": "10"})
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    assert picture_at(path, 0, 100).shape == (64, 96, 3)
