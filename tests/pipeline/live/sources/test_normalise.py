"""Pictures of any camera or file become frames of the live layout."""

from contextlib import closing
from fractions import Fraction

import numpy as np
import pytest
from makeup_video.pipeline.frames.frame import plane_views
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE
from makeup_video.pipeline.live.sources.camera import CameraSettings, open_source
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera
from media import make_clip, picture


@pytest.mark.parametrize(
    ("pix_fmt", "matrix", "span"),
    [("yuvj422p", 5, 2), ("yuvj420p", 5, 2), ("yuyv422", 6, 1), ("nv12", 6, 1), ("uyvy422", 6, 1)],
)
def test_a_cameras_picture_becomes_420_with_true_tags(pix_fmt, matrix, span):
    shown = picture(3, 64, 48, pix_fmt)
    luma = shown.reformat(format="yuvj422p" if span == 2 else "yuv422p", src_color_range=span,
                          dst_color_range=span)  # fmt: skip
    shown.color_range = 2 if span == 2 else 0
    shown.colorspace = 5 if span == 2 else 2  # as FFmpeg's decoders set it
    frame = NormaliseCamera(is_device=True)(shown, 12.5)
    assert (frame.pix_fmt, frame.tags.matrix, frame.tags.range) == ("yuv420p", matrix, span)
    assert (frame.tags.primaries, frame.tags.transfer) == (1, 1)
    np.testing.assert_array_equal(frame.planes[0], plane_views(luma, 8)[0])
    assert (frame.pts, frame.time_base) == (12_500_000, LIVE_TIME_BASE)
    assert (frame.picture.pts, frame.picture.time_base) == (12_500_000, LIVE_TIME_BASE)


def test_a_files_missing_tags_stay_missing():
    frame = NormaliseCamera(is_device=False)(picture(0, 64, 48), 0.0)
    assert (frame.tags.matrix, frame.tags.range, frame.tags.primaries) == (2, 0, 2)


def test_odd_sizes_become_even():
    frame = NormaliseCamera(is_device=True)(picture(0, 65, 47, "yuv422p"), 0.0)
    assert (frame.width_px, frame.height_px) == (66, 48)


@pytest.mark.parametrize(
    ("aspect", "size"),
    [(Fraction(16, 11), (140, 64)), (Fraction(8, 9), (96, 72)), (Fraction(1000), (96, 64))],
)
def test_a_videos_pixels_become_square_if_its_aspect_is_sane(tmp_path, aspect, size):
    clip = make_clip(tmp_path / "in.mp4", frames=2, sample_aspect_ratio=aspect)
    with closing(open_source(CameraSettings(name=str(clip)), pytest.fail)) as camera:
        frame = next(camera.frames())
    assert (frame.width_px, frame.height_px) == size


def test_square_pixels_keep_what_the_picture_means():
    shown = picture(0, 64, 48, "yuvj420p")
    shown.color_range, shown.colorspace = 2, 5
    shown.color_primaries = shown.color_trc = 6
    plane_views(shown, 8)[0][:] = 255
    frame = NormaliseCamera(is_device=False, pixel_aspect=Fraction(2))(shown, 0.0)
    assert frame.tags == NormaliseCamera(is_device=False)(shown, 0.0).tags
    assert frame.width_px == 128
    assert frame.planes[0].min() == 255


def test_times_increase_even_when_two_pictures_come_at_once():
    door = NormaliseCamera(is_device=True)
    pts = [door(picture(i, 16, 16), seconds).pts for i, seconds in enumerate((0.0, 0.0, 1.0, 0.5))]
    assert pts == [0, 100, 1_000_000, 1_000_100]


@pytest.mark.parametrize("size", [(64, 64), (32, 16), (200, 48), (63, 31)])
def test_another_size_is_fitted_into_the_first_undistorted(size):
    door = NormaliseCamera(is_device=True)
    door(picture(0, 64, 48), 0.0)
    other = picture(0, *size)
    for index, plane in enumerate(plane_views(other, 8)):
        plane[:] = 90 if index else 200
    frame = door(other, 1.0)
    assert (frame.width_px, frame.height_px) == (64, 48)
    filled = frame.planes[0] > 100
    width, height = filled.any(0).sum(), filled.any(1).sum()
    assert width == 64 or height == 48
    assert abs(width / height - size[0] / size[1]) <= 0.2 * size[0] / size[1]
    assert {16, 200} >= set(np.unique(frame.planes[0])[[0, -1]])


def test_another_range_is_brought_to_that_of_the_first():
    door = NormaliseCamera(is_device=True)
    door(picture(0, 64, 48, "yuvj420p"), 0.0)
    other = picture(0, 64, 48, "yuv420p")
    plane_views(other, 8)[0][:] = 235
    frame = door(other, 1.0)
    assert frame.tags.range == 2 and (frame.planes[0] == 255).all()
