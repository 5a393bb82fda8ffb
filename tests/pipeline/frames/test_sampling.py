"""Crops come straight from the planes, and match crops of the RGB picture."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.frames.affine import compose
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.sampling import (
    halved,
    sample,
)
from makeup_video.pipeline.frames.views import FramePicture, RgbPicture, _to_rgb_matrix
from people import frame_of, portrait

FACE = np.array([[1.9, 0.4, 120.0], [-0.4, 1.9, 190.0]])  # a turned window over the face
CLOSE = np.array([[0.6, 0.1, 220.0], [-0.1, 0.6, 260.0]])  # finer than the chroma of 4:2:0


def difference(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.abs(a.astype(int) - b.astype(int)).mean())


@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuv422p", "yuv444p", "nv12", "yuv420p10le",
                                     "yuv422p10le", "yuv444p10le"])  # fmt: skip
@pytest.mark.parametrize("matrix", [1, 5, 9])
@pytest.mark.parametrize("full_range", [False, True])
def test_every_layout_and_coding_gives_the_crop_of_rgb(pix_fmt, matrix, full_range):
    frame = frame_of(portrait(), pix_fmt=pix_fmt, matrix=matrix, full_range=full_range)
    for window in (FACE, CLOSE):
        got = FramePicture(frame).crop(window, (96, 80))
        want = RgbPicture(portrait()).crop(window, (96, 80))
        assert got.shape == (80, 96, 3)
        assert difference(got, want) < 2.5  # chroma is stored at half the size
        # FFmpeg's conversion to full range is off by half a code
        assert np.abs(got.mean((0, 1)) - want.mean((0, 1))).max() < 1.3


@pytest.mark.parametrize("rotation", [0, 90, 180, 270])
def test_a_stored_rotation_does_not_change_the_crop(rotation):
    frame = frame_of(portrait(), pix_fmt="yuv444p", rotation_degrees=rotation)
    picture = FramePicture(frame)
    assert (picture.width_px, picture.height_px) == portrait().shape[1::-1]
    want = RgbPicture(portrait()).crop(FACE, (96, 80))
    assert difference(picture.crop(FACE, (96, 80)), want) < 1


@pytest.mark.parametrize("rotation", [0, 90, 180, 270])
@pytest.mark.parametrize("aspect", [0.5, 1.5])
def test_wide_pixels_are_seen_square(rotation, aspect):
    upright = portrait()
    h, w = upright.shape[:2]
    sideways = rotation % 180 == 90
    size = (w, round(h / aspect)) if sideways else (round(w / aspect), h)
    stored = cv2.resize(upright, size, interpolation=cv2.INTER_AREA)
    picture = FramePicture(frame_of(stored, pix_fmt="yuv444p", rotation_degrees=rotation), aspect)
    assert picture.width_px == pytest.approx(w, abs=2)
    assert picture.height_px == pytest.approx(h, abs=2)
    want = RgbPicture(upright).crop(FACE, (96, 80))
    assert difference(picture.crop(FACE, (96, 80)), want) < 4


@pytest.mark.parametrize("rotation", [0, 90, 180, 270])
def test_to_stored_leads_to_the_same_pixel(rotation):
    upright = np.zeros((30, 50, 3), np.uint8)
    upright[7, 41] = 255
    frame = frame_of(upright, pix_fmt="yuv444p", rotation_degrees=rotation)
    x, y = FramePicture(frame).to_stored @ [41, 7, 1]
    assert frame.planes[0][round(y), round(x)] > 200


@settings(max_examples=60, deadline=None)
@given(
    scale=st.floats(0.02, 40),
    turn=st.floats(-4, 4),
    x=st.floats(-2000, 2000),
    y=st.floats(-2000, 2000),
    size=st.tuples(st.integers(1, 70), st.integers(1, 70)),
    pix_fmt=st.sampled_from(["yuv420p", "nv12", "yuv444p10le", "gray"]),
)
def test_any_map_over_any_picture_gives_a_crop(scale, turn, x, y, size, pix_fmt):
    rgb8 = np.arange(size[0] * size[1] * 3, dtype=np.uint8).reshape(size[1], size[0], 3)
    c, s = np.cos(turn) * scale, np.sin(turn) * scale
    window = np.array([[c, -s, x], [s, c, y]])
    crop = FramePicture(frame_of(rgb8, pix_fmt=pix_fmt)).crop(window, (33, 17))
    assert crop.shape == (17, 33, 3)
    assert crop.dtype == np.uint8


@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuv444p", "nv12", "yuv420p10le", "gray"])
@pytest.mark.parametrize("scale", [0.4, 1.0, 3.1])
@pytest.mark.parametrize("rotation", [0, 90])
def test_several_crops_at_once_are_the_crops_one_by_one(pix_fmt, scale, rotation):
    frame = frame_of(portrait(), pix_fmt=pix_fmt, rotation_degrees=rotation)
    c, s = scale * np.cos(0.2), scale * np.sin(0.2)
    large = np.array([[[c, -s, 200], [s, c, 250]]])
    small = np.array([
        [[-c, -s, 300], [s, c, 120]],
        [[c, s, -50], [-s, c, 580]],  # reaches beyond the border
    ])  # fmt: skip
    windows = (large, (40, 30)), (small, (16, 24))
    for picture in (FramePicture(frame), RgbPicture(portrait())):
        for got, (maps, size) in zip(picture.crops(windows), windows, strict=True):
            assert got.shape == (len(maps), *size[::-1], 3)
            for crop, to_px in zip(got, maps, strict=True):
                # a single window may have less detail than the same window among several
                assert difference(crop, picture.crop(to_px, size)) < 2


@pytest.mark.parametrize(
    "pix_fmt", ["yuv420p", "yuv422p", "yuv444p", "nv12", "yuv420p10le", "gray"]
)
@pytest.mark.parametrize("rotation", [0, 90, 180, 270])
@pytest.mark.parametrize("size", [(40, 50), (160, 200), (900, 1125)])
def test_the_whole_picture_is_seen_upright_at_any_size(pix_fmt, rotation, size):
    rgb8 = np.ascontiguousarray(portrait()[:500, :400])
    if pix_fmt == "gray":
        rgb8 = np.repeat(cv2.cvtColor(rgb8, cv2.COLOR_RGB2GRAY)[..., None], 3, axis=2)
    want = cv2.resize(rgb8, size, interpolation=cv2.INTER_AREA)
    frame = frame_of(rgb8, pix_fmt=pix_fmt, rotation_degrees=rotation)
    for picture in (FramePicture(frame), RgbPicture(rgb8)):
        got = picture.whole(size)
        assert got.shape == want.shape
        assert difference(got, want) < 7  # fewer samples; a shift by one pixel would give 10


def test_halving_averages_four_and_leaves_out_the_odd_one():
    plane = np.arange(35, dtype=np.uint8).reshape(5, 7)
    want = plane[:4, :6].reshape(2, 2, 3, 2).mean((1, 3))
    assert np.abs(halved(plane) - want).max() <= 0.5
    for shape in ((1, 1), (1, 4), (3, 1)):
        assert halved(np.full(shape, 9, np.uint8)).max() == 9


@pytest.mark.parametrize("scale", [1.5, 3.0, 6.0, 12.0, 24.0])
def test_reading_every_second_row_moves_nothing(scale):
    """A gradient stays the same at any size, so a shift of half a row would show."""
    slope = np.repeat(np.arange(0, 256, 0.25, np.float32)[:, None], 1024, axis=1)
    window = np.array([[scale, 0, 30.0], [0, scale, 30.0]])
    for plane in (slope, np.ascontiguousarray(slope.T)):
        got = sample(plane, window, (30, 30))
        want = 0.25 * (30 + scale * np.arange(30))
        along = got.mean(1) if plane is slope else got.mean(0)
        np.testing.assert_allclose(along, want, atol=0.01 * scale)


@pytest.mark.parametrize("scale", [1.0, 2.0, 3.7, 8.0, 30.0])
def test_a_shrinking_crop_averages_and_does_not_alias(scale):
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 256, (900, 900, 3), dtype=np.uint8)
    window = np.array([[scale, 0, 10], [0, scale, 10]])
    crop = RgbPicture(noise).crop(window, (20, 20)).astype(float)
    expected = 74 / max(scale / 2, 1)  # a mean over n x n px deviates n times less
    assert crop.std() < 1.4 * expected
    assert abs(crop.mean() - 127.5) < 4 * expected / 20 + 1


def test_a_crop_beyond_the_picture_repeats_the_border():
    rgb8 = np.zeros((40, 40, 3), np.uint8)
    rgb8[:, -1] = (10, 200, 30)
    far = np.array([[1, 0, 500.0], [0, 1, 10.0]])
    assert (RgbPicture(rgb8).crop(far, (8, 8)) == (10, 200, 30)).all()


def test_compose_does_the_first_map_first():
    double, shift = np.array([[2, 0, 0], [0, 2, 0]]), np.array([[1, 0, 5], [0, 1, 7]])
    assert compose(double, shift) @ [1, 1, 1] == pytest.approx([12, 16])


@pytest.mark.parametrize("matrix", [1, 2, 5, 6, 9])
@pytest.mark.parametrize(("range_", "black", "white"), [(1, 16, 235), (2, 0, 255), (0, 16, 235)])
def test_black_and_white_codes_are_black_and_white_in_rgb(matrix, range_, black, white):
    to_rgb = _to_rgb_matrix(ColourTags(matrix, range_), 640, 360)
    assert to_rgb @ [black, 128, 128, 1] == pytest.approx([0, 0, 0])
    assert to_rgb @ [white, 128, 128, 1] == pytest.approx([255, 255, 255])


@pytest.mark.parametrize(("size", "matrix"), [((640, 480), 6), ((1920, 1080), 1)])
def test_untagged_videos_count_as_players_take_them(size, matrix):
    untagged, tagged = (_to_rgb_matrix(ColourTags(code), *size) for code in (2, matrix))
    np.testing.assert_array_equal(untagged, tagged)


@pytest.mark.parametrize("full_range", [False, True])
def test_faces_are_found_in_colours_that_cannot_be_painted(full_range):
    """The nets read ICtCp as if it were BT.709."""
    range_ = 2 if full_range else 1
    unknown, known = (_to_rgb_matrix(ColourTags(matrix, range_), 1920, 1080) for matrix in (14, 1))
    np.testing.assert_array_equal(unknown, known)


@pytest.mark.parametrize("bad", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3), np.float32),
                                 np.zeros((0, 4, 3), np.uint8), np.zeros((4, 4, 4), np.uint8)])  # fmt: skip
def test_anything_but_an_rgb8_picture_is_refused_by_name(bad):
    with pytest.raises(ValueError, match=r"must be \(H, W, 3\) uint8"):
        RgbPicture(bad)
