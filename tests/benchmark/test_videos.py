"""Videos for measurements: of the requested length, without jumps, with a face of known size."""

from fractions import Fraction
from itertools import islice, pairwise

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.benchmark import videos
from makeup_video.pipeline import InputError, find_faces
from makeup_video.pipeline.faces.find import find_faces_in_frame
from media import decoded, make_clip, packets_of, times_of
from people import SAMPLES, clip, grey, write_video

UNIQUE = 40


def numbered(index):
    """A picture whose grey level encodes its number, which survives encoding."""
    return grey(64, 48) // 110 * (20 + 5 * index)


def number_of(picture):
    return round((picture.to_ndarray(format="rgb24").mean() - 20) / 5)


def bounce(index, unique):
    """0 1 2 ... n-1 n-2 ... 1 0 1 ..."""
    step = index % max(2 * (unique - 1), 1)
    return min(step, 2 * (unique - 1) - step)


@pytest.fixture(scope="module")
def numbers(tmp_path_factory):
    """{count: a video of `count` numbered pictures, with a keyframe in every group}"""
    folder, clips = tmp_path_factory.mktemp("numbers"), {}
    for count in (1, 2, 3, 15, 16, 31, UNIQUE):
        clips[count] = folder / f"{count}.mkv"
        pictures = (
            av.VideoFrame.from_ndarray(numbered(i), format="rgb24").reformat(format="yuv420p")
            for i in range(count)
        )
        options = {"preset": "ultrafast", "crf": "12", "g": str(videos._GROUP)}
        assert videos.write_video(clips[count], pictures, options) == count
    return clips


@pytest.mark.parametrize("unique", [1, 2, 3, 15, 16, 31, UNIQUE])
def test_frames_play_back_and_forth_without_a_jump(numbers, unique):
    count = 3 * unique + 5
    played = [
        number_of(picture)
        for picture in islice(videos._there_and_back(numbers[unique], unique), count)
    ]
    assert played == [bounce(index, unique) for index in range(count)]


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    target = tmp_path_factory.mktemp("sample") / "face.mp4"
    return videos.make_video(SAMPLES / "in.mp4", target, 240, 70)


def test_a_clip_has_the_size_and_length_asked_for(sample):
    assert sample.size_wh == (426, 240) and sample.frames == 70
    assert times_of(sample.path) == [Fraction(n, 30) for n in range(70)]
    first = decoded(sample.path)[0]
    assert (first.width, first.height, first.format.name) == (426, 240, "yuv420p")
    assert "0.5 of the height" in sample.description


def test_the_face_fills_half_the_height(sample):
    for picture in decoded(sample.path)[::23]:
        (face,) = find_faces_in_frame(videos.frame_of(picture))[0].faces
        top, chin = face.points_px[[10, 152], :2]
        assert np.linalg.norm(top - chin) == pytest.approx(120, rel=0.1)
        assert abs((top + chin)[0] / 2 - 213) < 24


def test_neighbouring_frames_are_alike_at_the_turns_too(tmp_path):
    short = write_video(tmp_path / "short.mkv", clip(20))
    made = videos.make_video(short, tmp_path / "long.mp4", 120, 60)
    lumas = [picture.to_ndarray()[:120].astype(int) for picture in decoded(made.path)]
    steps = [np.abs(b - a).mean() for a, b in pairwise(lumas)]
    assert len(lumas) == 60 and max(steps) < 3  # codes


def test_a_clip_can_be_taken_as_it_is(tmp_path):
    made = videos.make_video(SAMPLES / "in.mp4", tmp_path / "a.mp4", 180, 3, as_is=True)
    assert made.size_wh == (320, 180) and not made.is_cropped and "1 face" in made.description


def test_several_faces_are_left_as_they_are(tmp_path):
    both = [np.hstack([rgb8, rgb8]) for rgb8 in clip(2)]
    made = videos.make_video(write_video(tmp_path / "two.mkv", both), tmp_path / "a.mp4", 180, 4)
    assert made.faces == 2 and not made.is_cropped and made.size_wh == (640, 180)


def test_a_clip_without_a_face_is_refused(tmp_path):
    source = write_video(tmp_path / "grey.mkv", [grey(64, 48)] * 3)
    with pytest.raises(InputError, match="no face to paint on in 1 of the 1 frames"):
        videos.make_video(source, tmp_path / "out.mp4", 48, 3)


def test_a_damaged_clip_is_refused(tmp_path):
    source = make_clip(tmp_path / "short.mp4", size_wh=(640, 360))
    data = bytearray(source.read_bytes())
    for offset in range(48, len(data) // 2, 64):  # all packets, but not the tables at the end
        data[offset : offset + 32] = bytes(32)
    source.write_bytes(data)
    with pytest.raises(InputError, match=r"short\.mp4 is damaged"):
        videos.make_video(source, tmp_path / "out.mp4", 120, 6)


def test_a_turned_clip_is_measured_upright(tmp_path):
    turned = write_video(tmp_path / "turned.mkv", clip(2), rotation_degrees=90)
    made = videos.make_video(turned, tmp_path / "a.mp4", 180, 2)
    assert made.faces == 1 and made.is_cropped
    (face,) = find_faces(next(iter(decoded(made.path))).to_ndarray(format="rgb24"))
    forehead, chin = face.points_px[[10, 152], :2]
    assert abs(chin[0] - forehead[0]) < 20
    assert chin[1] - forehead[1] == pytest.approx(90, rel=0.15)  # half of the height


@given(
    st.integers(0, 2000), st.integers(0, 1000), st.integers(20, 900),
    st.sampled_from((16 / 9, 8 / 9)),
)  # fmt: skip
def test_the_crop_stays_in_the_picture_where_it_fits(x, y, tall, aspect):
    size = 2000, 1400
    x0, y0, x1, y1 = videos._around((x, y, x, y + tall), aspect, size)
    assert y1 - y0 == pytest.approx(2 * tall, abs=1)
    assert x1 - x0 == pytest.approx(aspect * (y1 - y0), abs=1)
    if y1 - y0 <= size[1]:
        assert y0 >= 0 and y1 <= size[1]
    if x1 - x0 <= size[0]:
        assert x0 >= 0 and x1 <= size[0]


def test_a_video_that_loops_can_be_repeated_without_encoding(tmp_path):
    short = videos.make_video(SAMPLES / "in.mp4", tmp_path / "one.mp4", 120, 21, loops=True)
    assert short.frames == 20
    video = videos.repeat_video(short.path, tmp_path / "long.mp4", 3)
    assert times_of(video) == [Fraction(n, 30) for n in range(60)]
    assert {data for _, data in packets_of(video, "video")} == {
        data for _, data in packets_of(short.path, "video")
    }
    lumas = [picture.to_ndarray()[:120].astype(int) for picture in decoded(video)]
    assert all((a == b).all() for a, b in zip(lumas, lumas[20:], strict=False))
    assert np.abs(lumas[19] - lumas[20]).mean() < 3


@pytest.mark.parametrize("count", [1, 3, 8])
def test_tiles_show_the_given_number_of_copies(numbers, tmp_path, count):
    tiled = decoded(videos.tile(numbers[3], tmp_path / "tiled.mp4", count, (4, 2)))
    assert len(tiled) == 3 and (tiled[0].width, tiled[0].height) == (256, 96)
    rgb8 = tiled[1].to_ndarray(format="rgb24").astype(int)
    tiles = [rgb8[y : y + 48, x : x + 64].mean() for y in (0, 48) for x in range(0, 256, 64)]
    assert tiles == pytest.approx([25] * count + [110] * (8 - count), abs=3)
