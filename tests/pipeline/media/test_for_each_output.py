"""Several outputs of one video: each refuses losses, and each fails alone."""

import pytest
from makeup_video.pipeline import (
    Look,
    OutputError,
    Settings,
    StrictError,
    process_looks,
    process_video,
)
from makeup_video.pipeline.media.mux import Muxer
from media import make_clip


def test_strict_refuses_losses_of_several_looks_as_of_one(tmp_path):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt="yuva420p")
    settings = Settings(codec="h264", bit_depth=8, strict=True)
    with pytest.raises(StrictError, match="transparency"):
        process_video(src, tmp_path / "one.mkv", None, settings)
    done = process_looks(src, {tmp_path / f"{name}.mkv": Look() for name in "ab"}, settings)
    for outcome in done.values():
        assert isinstance(outcome, StrictError) and "transparency" in str(outcome)
    assert [path.name for path in tmp_path.iterdir()] == ["in.mkv"]


def test_losses_of_several_looks_are_reported_once_for_each(tmp_path):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt="yuva420p")
    looks = {tmp_path / f"{name}.mkv": Look() for name in "ab"}
    for report in process_looks(src, looks, Settings(codec="h264")).values():
        (line,) = report.dropped
        assert line.startswith("transparency: h264 has none here")


def test_an_output_that_takes_no_packet_makes_room_at_once(tmp_path, monkeypatch):
    """On a full disk, the other outputs need the room."""
    src, parts = make_clip(tmp_path / "in.mkv", frames=60, audio="aac"), []
    copy, lost = Muxer.copy, tmp_path / "a.part.mkv"

    def full(self, packet, **more):
        if self.part == lost and packet.pts > 1000:
            raise OutputError("No space left on device")
        copy(self, packet, **more)
        if self.part != lost:
            parts.append(lost.exists())

    monkeypatch.setattr(Muxer, "copy", full)
    a, b = process_looks(src, {tmp_path / f"{name}.mkv": Look() for name in "ab"}).values()
    assert isinstance(a, OutputError) and b.frames_out == 60
    assert parts[0] and not parts[-1]
