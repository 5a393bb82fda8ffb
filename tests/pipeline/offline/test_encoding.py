"""What a video is encoded as: where few players would show it, a line says so."""

import pytest
from makeup_video.pipeline import Settings, process_video
from media import make_clip


@pytest.mark.parametrize(
    ("codec", "pix_fmt", "settings", "notes"),
    [
        ("ffv1", "yuv444p12le", {}, ["few players show hevc of 4:4:4; av1 has 4:2:0 alone"]),
        ("ffv1", "yuv422p10le", {}, ["few players show hevc of 4:2:2; av1 has 4:2:0 alone"]),
        ("ffv1", "yuv422p", {}, ["few players show h264 of 4:2:2; av1 has 4:2:0 alone"]),
        ("ffv1", "yuv420p10le", {}, []),
        ("h264", "yuv422p", {}, []),  # whoever has it plays it
        ("ffv1", "yuv444p", {"codec": "av1"}, []),
    ],
)  # fmt: skip
def test_a_line_says_where_few_players_show_it(tmp_path, codec, pix_fmt, settings, notes):
    src = make_clip(tmp_path / "in.mkv", codec=codec, pix_fmt=pix_fmt, frames=2)
    report = process_video(src, tmp_path / "out.mp4", None, Settings(**settings))
    said = [line.removeprefix("encoder: ") for line in report.warnings() if "players" in line]
    assert said == notes
