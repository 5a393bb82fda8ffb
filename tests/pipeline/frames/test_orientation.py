"""The table of EXIF orientations matches Pillow's transposition, and the turn of videos FFmpeg's."""

import av
import numpy as np
import pytest
from makeup_video.pipeline.frames.orientation import (
    ORIENTATIONS,
    UPRIGHT,
    orientation_of,
    turn_of,
)
from media import add_video, encode_frames
from PIL import Image


@pytest.mark.parametrize("number", ORIENTATIONS)
def test_turning_and_mirroring_is_pillows_transposition(number):
    stored = np.arange(6, dtype=np.uint8).reshape(2, 3)
    orientation = ORIENTATIONS[number]
    upright = np.rot90(stored, orientation.turn_degrees // 90)
    if orientation.is_mirrored:
        upright = upright[:, ::-1]
    picture = Image.fromarray(stored)
    if orientation.transposition:
        picture = picture.transpose(Image.Transpose[orientation.transposition])
    np.testing.assert_array_equal(np.array(picture), upright)


def test_all_eight_orientations_differ():
    assert set(ORIENTATIONS) == set(range(1, 9)) and len(set(ORIENTATIONS.values())) == 8


@pytest.mark.parametrize("value", [0, 9, -1, 99])
def test_other_numbers_mean_upright(value):
    assert orientation_of(value) is UPRIGHT


@pytest.mark.parametrize("degrees", [None, 0, 90, 180, 270])
@pytest.mark.parametrize("hflip", [False, True])
@pytest.mark.parametrize("vflip", [False, True])
def test_a_mirrored_video_is_turned_as_before_it_was_mirrored(tmp_path, degrees, hflip, vflip):
    path = tmp_path / "in.mp4"
    with av.open(str(path), "w") as out:
        stream = add_video(out)
        if degrees is not None:
            stream.set_display_rotation(degrees, hflip, vflip)
        encode_frames(out, stream, range(2))
    with av.open(str(path)) as container:
        picture = next(container.decode(video=0))
    upside_down = degrees is not None and vflip  # a turn by 180 degrees, and left for right
    assert turn_of(picture) == ((degrees or 0) + 180 * upside_down) % 360
    if not (hflip or vflip):
        assert turn_of(picture) == round(picture.rotation) % 360
