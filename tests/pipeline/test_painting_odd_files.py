"""Painting what is unlike the usual file, face or caller."""


import pytest
from makeup_video.pipeline import Look, Settings, process_video, product
from media import decoded
from people import clip, film

RED = Look(lips=product((180, 0, 46), "matte"))


@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuv422p", "yuv420p10le"])
@pytest.mark.parametrize("cut", [(0, 1), (1, 0), (1, 1)])
def test_lossless_films_of_odd_size_are_painted(tmp_path, pix_fmt, cut):
    pictures = [rgb8[cut[0] :, cut[1] :] for rgb8 in clip(2)]
    src = film(tmp_path / "in.mkv", pictures, pix_fmt)
    report = process_video(src, tmp_path / "out.mkv", RED, Settings(codec="ffv1"))
    assert report.painted_frames == 2 and report.warnings() == []
    assert decoded(tmp_path / "out.mkv")[0].width == pictures[0].shape[1]
