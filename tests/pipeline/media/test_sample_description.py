"""The report has a line for what mp4 and mov say of a video and its output cannot say."""

import pytest
from makeup_video.pipeline import Settings, StrictError, process_video
from makeup_video.pipeline.media import encode
from makeup_video.pipeline.media.input_file import open_video
from makeup_video.pipeline.media.sample_description import lost_descriptions
from media import make_clip
from mp4_files import box, clap, describe

DOLBY = "tag of Dolby Vision: it describes the unpainted picture"
CLEAN = "clean aperture of 90x60 px: the whole picture is shown"


@pytest.fixture(params=[".mp4", ".mov"])
def source(request, tmp_path):
    return make_clip(tmp_path / f"in{request.param}", "hevc", frames=3)


@pytest.mark.parametrize(
    ("boxes", "codec", "lines"),
    [
        ([box(b"dvvC", bytes(24))], None, [DOLBY]),
        ([box(b"dvcC", bytes(24))], b"dvh1", [DOLBY]),
        ([], b"dvhe", [DOLBY]),
        ([clap(90, 60)], None, [CLEAN]),
        ([clap(96, 64)], None, []),
        ([clap(96, 64, right=1)], None, ["clean aperture of 96x64 px: the whole picture is shown"]),
        ([clap(90, 60), box(b"dvvC", bytes(24))], None, [DOLBY, CLEAN]),
        ([box(b"free", bytes(24))], None, []),
        ([clap(90, 60)[:20]], None, []),  # cut short
        ([clap(0, 0)], None, []),
    ],
)
def test_what_is_not_written_is_reported(source, boxes, codec, lines):
    describe(source, *boxes, codec=codec)
    out = source.with_name("out.mp4")
    assert process_video(source, out).dropped == lines
    assert process_video(out, source.with_name("again.mp4")).dropped == []
    if lines:
        with pytest.raises(StrictError, match=lines[0].partition(":")[0]):
            process_video(source, source.with_name("s.mkv"), None, Settings(strict=True))


def test_segments_report_it_once(tmp_path):
    source = describe(make_clip(tmp_path / "in.mp4", frames=120, options={"g": "20"}), clap(90, 60))
    report = process_video(source, tmp_path / "out.mp4", None, Settings(split_minutes=0.02))
    assert report.segments > 1 and report.dropped == [CLEAN]


def test_one_line_about_dolby_vision_is_enough(tmp_path, monkeypatch):
    """Frames that carry its numbers have a line already."""
    dynamic = "Dolby Vision dynamic metadata: it describes the unpainted picture"
    monkeypatch.setattr(encode, "hdr_parameters", lambda picture, codec: ([], [dynamic]))
    source = make_clip(tmp_path / "in.mp4", "hevc", frames=3)
    describe(source, box(b"dvvC", bytes(24)), clap(90, 60))
    assert process_video(source, tmp_path / "out.mp4").dropped == [dynamic, CLEAN]


def test_other_tracks_containers_and_lost_files_have_no_line(tmp_path):
    source = describe(make_clip(tmp_path / "in.mp4", frames=3), clap(90, 60))
    other = make_clip(tmp_path / "in.mkv", frames=3)
    for path, count in ((source, 1), (other, 0)):
        opened = open_video(path)
        assert len(lost_descriptions(opened)) == count
        path.unlink()
        assert lost_descriptions(opened) == []
        opened.close()
