"""Thumbnails are upright; input and output show one moment; unreadable files have none."""

from fractions import Fraction

import av
import cv2
import numpy as np
import pytest
from makeup_video.pipeline.batch.thumbnails import thumbnail, thumbnails
from makeup_video.pipeline.images import picture_size
from media import add_video, make_clip
from people import TICK, clip, write_video


def shown(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)[..., ::-1].astype(int)


def off(data, rgb8):
    want = cv2.resize(rgb8, (240, 135), interpolation=cv2.INTER_AREA).astype(int)
    return np.abs(shown(data) - want).mean()


@pytest.mark.parametrize("rotation", [0, 90, 180, 270])
def test_a_moment_of_a_video_is_shown_upright(tmp_path, rotation):
    src = write_video(tmp_path / "in.mkv", clip(40), rotation_degrees=rotation)
    assert off(thumbnail(src), clip(40)[30]) < 4
    assert off(thumbnail(src, 1.2), clip(40)[39]) < 4  # the last frame


def test_input_and_output_are_shown_at_the_same_moment(tmp_path):
    src = write_video(tmp_path / "in.mkv", clip(40))
    part = write_video(tmp_path / "out.mkv", clip(40)[6:])
    before, after = thumbnails(str(src), str(part), 0.2)
    assert np.abs(shown(before) - shown(after)).mean() < 1
    assert off(after, clip(40)[36]) < 4


def test_large_pictures_shrink_and_small_ones_stay(tmp_path):
    for size, expected in (((30, 20), (30, 20)), ((2000, 500), (240, 60)), ((10, 3000), (1, 240))):
        cv2.imwrite(str(tmp_path / "a.png"), np.full((size[1], size[0], 3), 90, np.uint8))
        assert shown(thumbnail(tmp_path / "a.png")).shape[1::-1] == expected


def test_an_output_may_be_larger_than_any_input(tmp_path, monkeypatch):
    large = tmp_path / "a.png"
    cv2.imwrite(str(large), np.full((40, 60, 3), 90, np.uint8))
    monkeypatch.setattr(picture_size, "MOST_PX", 1000)
    before, after = thumbnails(str(large), str(large), 0.0)
    assert before is None and shown(after).shape[1::-1] == (60, 40)


@pytest.mark.parametrize("data", [b"", b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n", b"no video at all"])
def test_an_unreadable_file_has_no_picture(tmp_path, data):
    (tmp_path / "a.mp4").write_bytes(data)
    assert thumbnail(tmp_path / "a.mp4") is None
    assert thumbnail(tmp_path / "missing.mp4") is None


def test_untagged_colours_mean_what_they_mean_to_the_product(tmp_path):
    """Untagged HD video counts as BT.709, smaller video as BT.601."""
    for size_wh, matrix in (((1280, 720), 1), ((640, 360), 5)):
        red = np.full((size_wh[1], size_wh[0], 3), (200, 40, 60), np.uint8)
        frame = av.VideoFrame.from_ndarray(red, format="rgb24").reformat(
            format="yuv420p", dst_colorspace=matrix, dst_color_range=1
        )
        frame.colorspace, frame.color_range = 2, 0
        with av.open(str(tmp_path / "in.mkv"), "w") as out:
            stream = add_video(out, "ffv1", size_wh=size_wh)
            for pts in range(3):
                frame.pts, frame.time_base = pts, TICK
                out.mux(stream.encode(frame))
            out.mux(stream.encode(None))
        seen = shown(thumbnail(tmp_path / "in.mkv")).mean((0, 1))
        assert np.abs(seen - (200, 40, 60)).max() < 6


@pytest.mark.parametrize(("aspect", "expected"), [("2/1", (240, 90)), ("1/2", (160, 240))])
def test_pixels_that_are_not_square_become_so(tmp_path, aspect, expected):
    size_wh = (640, 480)
    path = make_clip(tmp_path / "in.mkv", size_wh=size_wh, sample_aspect_ratio=Fraction(aspect))
    assert shown(thumbnail(path)).shape[1::-1] == expected
