"""The report has a line for side data of pictures that an output loses."""

import struct

import pytest
from makeup_video.pipeline import Settings, StrictError, process_video
from makeup_video.pipeline.frames.side_data import all_side_data
from makeup_video.pipeline.media import lost_side_data as module
from makeup_video.pipeline.media.codecs import CODECS
from media import decoded, make_clip
from mp4_files import box, describe


@pytest.fixture
def lost_side_data(monkeypatch):
    """lost_side_data for pictures that are sets of names, because PyAV cannot add side data."""

    def found(picture, name):
        return b"\xfc\x94\x20" if name in picture else None

    monkeypatch.setattr(module, "side_data", found)
    return module.lost_side_data


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


STEREO = box(b"st3d", bytes([0, 0, 0, 0, 2]))  # the left and the right view side by side
MONO = box(b"st3d", bytes(5))
AMBIENT = box(b"amve", struct.pack(">I2H", 3_140_000, 15635, 16450))


@pytest.mark.parametrize("end", [".mp4", ".mov"])
@pytest.mark.parametrize(
    ("more", "codec", "line"),
    [
        (AMBIENT, "h264", "ambient viewing environment: it is not written"),
        (AMBIENT, "hevc", "ambient viewing environment: it is not written"),
        (STEREO, "h264", None),
        (STEREO, "hevc", "tags of a stereo 3D video: hevc cannot carry them; use h264"),
        (MONO, "hevc", None),
    ],
)
def test_boxes_about_the_screen_are_kept_or_reported(tmp_path, end, more, codec, line):
    source = describe(make_clip(tmp_path / f"in{end}", frames=3), more)
    report = process_video(source, tmp_path / f"out{end}", None, Settings(codec=codec))
    assert report.dropped == ([] if line is None else [line])
    if line is None and more == STEREO:
        names = {kind.name for kind in all_side_data(decoded(tmp_path / f"out{end}")[0])}
        assert "STEREO3D" in names  # in the stream itself
    if line is not None:
        strict = Settings(codec=codec, strict=True)
        with pytest.raises(StrictError, match=line.partition(":")[0]):
            process_video(source, tmp_path / "strict.mkv", None, strict)


@pytest.mark.parametrize("kind", range(9))
def test_h264_has_no_number_for_some_kinds_of_stereo(monkeypatch, kind):
    def found(picture, name):
        return struct.pack("=2i", kind, 0) if name == "STEREO3D" else None

    monkeypatch.setattr(module, "side_data", found)
    is_lost = kind in (5, 8)
    assert bool(module.lost_side_data(set(), CODECS["h264"])) == is_lost
