"""Opening an input: which video stream is painted, and which files are never opened."""

from fractions import Fraction

import av
import pytest
from makeup_video.pipeline import InputError
from makeup_video.pipeline.media.input_file import open_video
from media import add_video, encode_frames, make_clip


@pytest.mark.parametrize("chosen", [0, 1, 2])
def test_of_several_videos_the_one_marked_default_is_painted(tmp_path, chosen):
    with av.open(str(tmp_path / "in.mkv"), "w") as out:
        streams = [add_video(out, size_wh=size_wh) for size_wh in ((64, 48), (80, 60), (96, 64))]
        for index, stream in enumerate(streams):
            stream.disposition = int(index == chosen)
        for stream in streams:
            encode_frames(out, stream, range(5))
    source = open_video(tmp_path / "in.mkv")
    assert source.video.index == chosen
    source.close()


@pytest.mark.parametrize("rate", [(24000, 1001), (25, 1), (60000, 1001)])
def test_rate_and_number_of_frames_are_known_before_decoding(tmp_path, rate):
    source = open_video(make_clip(tmp_path / "in.mp4", rate=Fraction(*rate), frames=20))
    assert source.rate == Fraction(*rate)
    assert source.expected_frames == 20
    source.close()


def test_without_a_count_the_number_of_frames_is_estimated(tmp_path):
    source = open_video(make_clip(tmp_path / "in.mkv", frames=60))
    assert source.expected_frames == pytest.approx(60, abs=1)
    source.close()


def test_an_absurd_frame_rate_is_not_trusted(tmp_path):
    """A millisecond clock makes FFmpeg guess 1000 frames/s for irregular times."""
    pts = [0, 1, 3, 600, 1900]
    source = open_video(make_clip(tmp_path / "in.mkv", pts=pts, time_base=Fraction(1, 1000)))
    assert source.rate <= 240
    source.close()


@pytest.mark.parametrize(
    ("pix_fmt", "alpha", "depth"),
    [("yuv420p", False, 8), ("yuva420p", True, 8), ("yuv420p10le", False, 10)],
)
def test_depth_and_transparency_are_known_before_decoding(tmp_path, pix_fmt, alpha, depth):
    source = open_video(make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt=pix_fmt))
    assert (source.has_alpha, source.bit_depth) == (alpha, depth)
    source.close()


def test_a_name_in_any_script_opens(tmp_path):
    source = open_video(make_clip(tmp_path / "in.mp4").rename(tmp_path / "Ärger 眼影 ¿?.mp4"))
    assert source.video.width == 96
    source.close()


@pytest.mark.parametrize("end", [".mp4", ".mov"])
@pytest.mark.parametrize("size", ["as it is", "until the end", "begun"])
def test_a_recording_without_an_index_is_called_unfinished(tmp_path, end, size):
    path = make_clip(tmp_path / f"in{end}")
    data = path.read_bytes()
    at = data.index(b"mdat") - 4
    if size == "until the end":  # as it is while FFmpeg writes
        data = data[:at] + bytes(4) + data[at + 4 :]
    path.write_bytes(data[: at + 8] if size == "begun" else data[: data.index(b"moov") - 4])
    with pytest.raises(InputError, match=r"has no index: .* is still being written, .* repair it"):
        open_video(path)


@pytest.mark.parametrize("data", [b"no video", b"\0\0\0\x0cjP  \r\n\x87\n" + bytes(40), bytes(90)])
def test_what_is_no_mp4_is_not_called_unfinished(tmp_path, data):
    (tmp_path / "in.mp4").write_bytes(data)
    with pytest.raises(InputError, match="is not a video or picture file that can be read"):
        open_video(tmp_path / "in.mp4")


def test_a_damaged_index_is_not_called_unfinished(tmp_path):
    path = make_clip(tmp_path / "in.mp4")
    data = path.read_bytes()
    at = data.index(b"moov") + 4
    path.write_bytes(data[:at] + bytes(len(data) - at))
    with pytest.raises(InputError, match="has no video stream"):
        open_video(path)
