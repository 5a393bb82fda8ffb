"""FFmpeg's converter uses the matrix and range of the frame."""

from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import av
import numpy as np
import pytest
from makeup_video.kernels.colour import LUMA_WEIGHTS, Coding, matrices
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame, plane_views
from makeup_video.pipeline.frames.transform import fitted, upright, upright_rgb
from makeup_video.pipeline.live.sinks.virtual_camera import as_webcam
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera
from media import picture

CODES = 120, 100, 170  # a strong red, in which the matrices differ by up to 9 codes


def frame_of(matrix, full_range, pix_fmt):
    """A frame of one colour, tagged with a matrix and a range."""
    picture = av.VideoFrame(64, 48, pix_fmt)
    for plane, code in zip(plane_views(picture, 8), CODES, strict=True):
        plane[:] = code
    return Frame(picture, 0, Fraction(1, 25), ColourTags(matrix, 2 if full_range else 1))


def rgb_of(codes, coding):
    to_rgb, _ = matrices(coding)
    return np.clip(to_rgb[:, :3] @ np.array(codes, np.float64) + to_rgb[:, 3], 0, 1) * 255


@pytest.mark.parametrize("matrix", LUMA_WEIGHTS)
@pytest.mark.parametrize("full_range", [False, True])
def test_rgb_follows_matrix_and_range(matrix, full_range):
    rgb = upright_rgb(frame_of(matrix, full_range, "yuv444p"))
    want = rgb_of(CODES, Coding(matrix, full_range))
    assert np.abs(rgb.astype(float) - want).max() < 1.1


@pytest.mark.parametrize(("full_range", "black"), [(False, 16), (True, 0)])
def test_bars_are_black_in_either_range(full_range, black):
    shown = frame_of(1, full_range, "yuv420p").picture
    shown.color_range = 2 if full_range else 1
    luma, blue, red = plane_views(fitted(shown, (96, 48)), 8)
    assert (luma[:, 16:80] == CODES[0]).all()
    assert (np.delete(luma, slice(16, 80), axis=1) == black).all()
    assert (np.delete(np.stack([blue, red]), slice(8, 40), axis=2) == 128).all()


@pytest.mark.parametrize("matrix", LUMA_WEIGHTS)
@pytest.mark.parametrize("full_range", [False, True])
def test_a_webcam_shows_the_colours_of_every_matrix(matrix, full_range):
    codes = [int(plane[5, 5]) for plane in as_webcam(frame_of(matrix, full_range, "yuv420p"))]
    shown, want = rgb_of(codes, Coding(6)), rgb_of(CODES, Coding(matrix, full_range))
    assert np.abs(shown - want).max() < 4  # codes are rounded before and after


def test_several_outputs_may_convert_a_frame_at_once():
    """The converter that PyAV keeps with each picture would crash and change the picture's tags."""
    frame = NormaliseCamera(is_device=True)(picture(5, 640, 480), 3.0)
    frame.picture.colorspace, frame.picture.color_range = 1, 2
    frame.tags = ColourTags.of(frame.picture)
    rgb, codes = upright_rgb(frame), as_webcam(frame)[0].copy()
    with ThreadPoolExecutor(2) as pool:
        for _ in range(40):
            one, two = pool.submit(upright_rgb, frame), pool.submit(as_webcam, frame)
            np.testing.assert_array_equal(one.result(), rgb)
            np.testing.assert_array_equal(two.result()[0], codes)
            assert (frame.picture.colorspace, frame.picture.color_range) == (1, 2)


@pytest.mark.parametrize("degrees", [0, 90, 180, 270])
def test_upright_turns_the_planes_counter_clockwise(degrees):
    frame = NormaliseCamera(is_device=True)(picture(5, 64, 48), 3.0)
    frame.rotation_degrees = degrees
    turned = upright(frame)
    assert turned.pts == frame.pts and (turned is frame.picture) == (degrees == 0)
    for new, old in zip(plane_views(turned, 8), frame.planes, strict=True):
        np.testing.assert_array_equal(new, np.rot90(old, degrees // 90))
