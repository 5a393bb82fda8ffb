"""Cover art and tags: MP4 holds either custom tags or cover art, and every loss is reported."""

import io

import av
import pytest
from makeup_video.pipeline import OutputError, Settings, StrictError, process_video
from makeup_video.pipeline.media.input_file import is_cover
from makeup_video.pipeline.media.mux import Muxer
from media import add_video, encode_frames
from PIL import Image


def picture_bytes():
    data = io.BytesIO()
    Image.new("RGB", (32, 32), (180, 0, 46)).save(data, "JPEG")
    return data.getvalue()


def with_cover(path, **tags):
    with av.open(str(path), "w") as out:
        stream = add_video(out)
        out.add_attachment("cover.jpg", "image/jpeg", picture_bytes())
        out.metadata.update(tags)
        encode_frames(out, stream, range(8))
    return path


def covers_of(path):
    with av.open(str(path)) as container:
        covers = {stream.index for stream in container.streams if is_cover(stream)}
        return [bytes(p) for p in container.demux() if p.size and p.stream.index in covers]


def tags_of(path):
    with av.open(str(path)) as container:
        return {key.lower(): value for key, value in container.metadata.items()}


@pytest.mark.parametrize("tags", [{}, {"title": "A video"}, {"TITLE": "A video", "ARTIST": "X"}])
@pytest.mark.parametrize("end", [".mp4", ".m4v"])
def test_a_cover_from_matroska_is_kept_with_the_ordinary_tags(tmp_path, tags, end):
    src = with_cover(tmp_path / "in.mkv", **tags)
    report = process_video(src, tmp_path / f"out{end}", None, Settings(strict=True))
    assert covers_of(tmp_path / f"out{end}") == [picture_bytes()] and report.dropped == []
    kept = tags_of(tmp_path / f"out{end}")
    assert all(kept[key.lower()] == value for key, value in tags.items())


def test_a_cover_goes_to_mp4_and_back(tmp_path):
    process_video(with_cover(tmp_path / "in.mkv"), tmp_path / "there.mp4")
    process_video(tmp_path / "there.mp4", tmp_path / "back.mkv")
    process_video(tmp_path / "back.mkv", tmp_path / "again.mp4")
    assert covers_of(tmp_path / "again.mp4") == [picture_bytes()]


def test_odd_tags_beside_a_cover_are_left_out_by_name(tmp_path):
    src = with_cover(tmp_path / "in.mkv", title="A video", Mood="calm")
    report = process_video(src, tmp_path / "out.mp4")
    assert covers_of(tmp_path / "out.mp4") == [picture_bytes()]
    assert len(report.dropped) == 1 and "mood" in report.dropped[0].lower()
    with pytest.raises(StrictError, match="cover art, not both"):
        process_video(src, tmp_path / "strict.mp4", None, Settings(strict=True))


def test_odd_tags_without_a_cover_are_kept(tmp_path):
    src = tmp_path / "in.mkv"
    with av.open(str(src), "w") as out:
        stream = add_video(out)
        out.metadata.update({"Mood": "calm"})
        encode_frames(out, stream, range(8))
    assert process_video(src, tmp_path / "out.mp4").dropped == []
    assert tags_of(tmp_path / "out.mp4")["mood"] == "calm"


def test_a_cover_that_the_file_lacks_at_the_end_is_noticed(tmp_path, monkeypatch):
    src = with_cover(tmp_path / "in.mkv")
    original_mux = Muxer._mux

    def mux_without_covers(self, stream, packet):
        if is_cover(stream):
            self._covers.add(stream.index)
        else:
            original_mux(self, stream, packet)

    monkeypatch.setattr(Muxer, "_mux", mux_without_covers)
    with pytest.raises(
        OutputError, match="it holds 0 pieces of cover art, but the number sent is 1"
    ):
        process_video(src, tmp_path / "out.mp4")
    assert not (tmp_path / "out.mp4").exists()
