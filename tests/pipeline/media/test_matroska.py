"""The display size, written into a finished Matroska file without moving any other byte."""

from fractions import Fraction

import av
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import Settings, process_video
from makeup_video.pipeline.media.matroska import set_display_size
from media import decoded, make_clip, packets_of, times_of


@pytest.mark.parametrize(("codec", "end"), [("vp9", ".webm"), ("av1", ".webm"), ("ffv1", ".mkv"),
                                            ("prores", ".mkv"), ("h264", ".mkv")])  # fmt: skip
@pytest.mark.parametrize("audio", [None, "libopus"])
def test_anamorphic_video_keeps_its_shape_and_all_its_data(tmp_path, codec, end, audio):
    src = make_clip(tmp_path / "in.mp4", sample_aspect_ratio=Fraction(16, 11), audio=audio)
    dst = tmp_path / f"out{end}"
    process_video(src, dst, None, Settings(codec=codec))
    with av.open(str(dst)) as container:
        video = container.streams.video[0]
        assert float(video.sample_aspect_ratio) == pytest.approx(16 / 11, rel=0.01)
        container.seek(200_000)  # the seek table and the cues still point at the right places
        assert next(container.decode(video)).pts is not None
    assert len(decoded(dst)) == 12
    if audio:
        assert [d for _, d in packets_of(src, "audio")] == [d for _, d in packets_of(dst, "audio")]


@pytest.mark.parametrize("end", [".mkv", ".webm"])
@pytest.mark.parametrize(
    ("width", "height", "aspect", "shown"),
    [
        (320, 256, Fraction(4, 3), b"\x84" + (5).to_bytes(4)),  # 426.7 x 256: a ratio of 5 to 3
        (720, 480, Fraction(8, 9), b"\x84" + (640).to_bytes(4)),  # in pixels
        (352, 288, Fraction(128, 117), b"\x84" + (1408).to_bytes(4)),  # a ratio of 1408 to 1053
    ],
)
def test_the_pixel_aspect_ratio_is_exact(tmp_path, end, width, height, aspect, shown):
    src = make_clip(
        tmp_path / "in.mp4", frames=2, size_wh=(width, height), sample_aspect_ratio=aspect
    )
    process_video(src, tmp_path / f"out{end}", None, Settings(codec="vp9"))
    with av.open(str(tmp_path / f"out{end}")) as container:
        assert container.streams.video[0].sample_aspect_ratio == aspect
    assert b"\x54\xb0" + shown in (tmp_path / f"out{end}").read_bytes()


@given(width=st.integers(1, 2**31), height=st.integers(1, 2**31))
@settings(deadline=None, max_examples=25)
def test_any_size_is_written_and_nothing_else_changes(tmp_path_factory, width, height):
    path = make_clip(tmp_path_factory.mktemp("mkv") / "in.mkv", "ffv1", frames=4, audio="flac")
    before = path.read_bytes()
    frames = [bytes(frame.planes[0]) for frame in decoded(path)]
    times = times_of(path)
    assert set_display_size(path, 1, (width, height))
    assert len(path.read_bytes()) == len(before)
    assert [bytes(frame.planes[0]) for frame in decoded(path)] == frames
    assert times_of(path) == times
    assert (0x54B0).to_bytes(2) + b"\x84" + width.to_bytes(4) in path.read_bytes()


def test_writing_it_twice_keeps_the_second():
    # the element is replaced, not repeated
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as folder:
        path = make_clip(Path(folder) / "in.mkv", "ffv1", frames=2)
        assert set_display_size(path, 1, Fraction(111, 64))
        assert set_display_size(path, 1, (192, 64))
        assert (0x54B2).to_bytes(2) not in path.read_bytes()[:2000]  # DisplayUnit is gone
        assert path.read_bytes().count(b"\x54\xb0\x84") == 1
        with av.open(str(path)) as container:
            assert container.streams.video[0].sample_aspect_ratio == 2


def test_without_a_gap_the_file_is_not_changed(tmp_path):
    path = make_clip(tmp_path / "in.mkv", "ffv1", frames=2)
    tight = path.read_bytes().replace(b"\xec\x01\x00\x00\x00", b"\xed\x01\x00\x00\x00", 1)
    path.write_bytes(tight)
    assert not set_display_size(path, 1, (10, 10))
    assert path.read_bytes() == tight
