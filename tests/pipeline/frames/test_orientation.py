"""The table of EXIF orientations matches Pillow's transposition."""

import numpy as np
import pytest
from makeup_video.pipeline.frames.orientation import ORIENTATIONS, UPRIGHT, orientation_of
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
