"""Side data of pictures that an output loses has a line."""

from types import SimpleNamespace

import pytest
from av.sidedata.sidedata import Type
from makeup_video.pipeline.media.codecs import CODECS
from makeup_video.pipeline.media.side_data import lost_side_data


def picture(*kinds):
    return SimpleNamespace(side_data={Type[kind]: b"\xfc\x94\x20" for kind in kinds})


@pytest.mark.parametrize("name", CODECS)
def test_captions_are_kept_or_reported(name):
    lost = lost_side_data(picture("A53_CC"), CODECS[name])
    kept = name in ("h264", "hevc")
    assert lost == (
        [] if kept else [f"closed captions: {name} cannot carry them; use h264 or hevc"]
    )
    assert not kept or CODECS[name].options(18, "fast").get("a53cc", "1") == "1"


@pytest.mark.parametrize("name", CODECS)
def test_tags_of_a_whole_sphere_are_reported(name):
    assert lost_side_data(picture(), CODECS[name]) == []
    (text,) = lost_side_data(picture("SPHERICAL"), CODECS[name])
    assert text.startswith("tags of a 360 degree video")
