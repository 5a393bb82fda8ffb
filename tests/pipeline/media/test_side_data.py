"""Side data of pictures that an output loses has a line."""

import pytest
from makeup_video.pipeline.media import side_data
from makeup_video.pipeline.media.codecs import CODECS


@pytest.fixture
def lost_side_data(monkeypatch):
    """The function, for pictures that are sets of what they have; PyAV cannot add side data."""

    def found(picture, name):
        return b"\xfc\x94\x20" if name in picture else None

    monkeypatch.setattr(side_data, "side_data", found)
    return side_data.lost_side_data


@pytest.mark.parametrize("name", CODECS)
def test_captions_are_kept_or_reported(lost_side_data, name):
    lost = lost_side_data({"A53_CC"}, CODECS[name])
    kept = name in ("h264", "hevc")
    assert lost == (
        [] if kept else [f"closed captions: {name} cannot carry them; use h264 or hevc"]
    )
    assert not kept or CODECS[name].options(18, "fast").get("a53cc", "1") == "1"


@pytest.mark.parametrize("name", CODECS)
def test_tags_of_a_whole_sphere_are_reported(lost_side_data, name):
    assert lost_side_data(set(), CODECS[name]) == []
    (text,) = lost_side_data({"SPHERICAL"}, CODECS[name])
    assert text.startswith("tags of a 360 degree video")
