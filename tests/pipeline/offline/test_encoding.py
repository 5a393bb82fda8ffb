"""How a video is encoded; a warning where few players can show the output."""

import pytest
from makeup_video.pipeline import Settings, process_video
from media import make_clip


@pytest.mark.parametrize(
    ("codec", "pix_fmt", "out", "settings", "notes"),
    [
        ("ffv1", "yuv444p12le", "out.mp4", {}, ["4:4:4 in hevc; av1 is always 4:2:0"]),
        ("ffv1", "yuv422p10le", "out.mp4", {}, ["4:2:2 in hevc; av1 is always 4:2:0"]),
        ("ffv1", "yuv422p", "out.mkv", {}, ["4:2:2 in h264; av1 is always 4:2:0"]),
        ("prores", "yuv422p10le", "out.mov", {}, ["4:2:2 in hevc"]),  # mov holds no av1
        ("ffv1", "yuv420p10le", "out.mp4", {}, []),
        ("h264", "yuv422p", "out.mp4", {}, []),  # the source is H.264 in 4:2:2 itself
        ("ffv1", "yuv444p", "out.mp4", {"codec": "av1"}, []),
        ("ffv1", "yuv422p10le", "out.mov", {"codec": "prores"}, []),
    ],
)  # fmt: skip
def test_a_line_says_where_few_players_can_show_the_output(
    tmp_path, codec, pix_fmt, out, settings, notes
):
    src = make_clip(tmp_path / "in.mkv", codec=codec, pix_fmt=pix_fmt, frames=2)
    report = process_video(src, tmp_path / out, None, Settings(**settings))
    begin = "encoder: few players can show "
    said = [line.removeprefix(begin) for line in report.warnings() if line.startswith(begin)]
    assert said == notes
