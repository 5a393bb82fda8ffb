"""Lids of shut eyes meet; open eyes stay as they were read."""

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Painter, find_faces, ready_look
from makeup_video.pipeline.faces import nets as face_nets
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.faces.shut_eyes import (
    NUMBERS,
    close_shut_eyes,
    numbers_of,
    opening_of,
)
from makeup_video.pipeline.faces.topology import EYE
from people import SAMPLES, portrait

SPAN = 0.72  # IOD
LID_POINTS = [*range(1, 8), *range(9, 16)]  # places in EYE: the lids without the corners


def always(odds):
    """A model that gives the same odds for every eye."""
    return np.append(np.zeros(NUMBERS), odds)


def eyes(opening, seed=0):
    """Points (2, 53, 3) float32 in IOD, open by `opening` eye widths, and crops of noise."""
    rng = np.random.default_rng(seed)
    points = rng.normal(0, 0.1, (2, len(EYE), 3))
    across = np.linspace(-0.15, 0.15, 9)
    arch = 0.3 * opening * np.sqrt(np.clip(1 - (across / 0.15) ** 2, 0, 1))
    points[:, :9, 0], points[:, :9, 1] = across, arch / 2
    points[:, 9:16, 0], points[:, 9:16, 1] = across[7:0:-1], -arch[7:0:-1] / 2
    return points.astype(np.float32), rng.integers(0, 256, (2, 48, 64, 3), dtype=np.uint8)


@given(opening=st.floats(0.21, 0.6), seed=st.integers(0, 99))
def test_an_open_eye_is_never_changed(opening, seed):
    points, crops = eyes(opening, seed)
    before = points.copy()
    close_shut_eyes(points, crops, always(100), SPAN)
    np.testing.assert_array_equal(points, before)


@given(opening=st.floats(0.001, 0.139), seed=st.integers(0, 99))
def test_the_lids_of_a_shut_eye_meet(opening, seed):
    points, crops = eyes(opening, seed)
    before = points.copy()
    close_shut_eyes(points, crops, always(100), SPAN)
    assert max(map(opening_of, points)) < 1e-5
    rest = np.setdiff1d(np.arange(len(EYE)), LID_POINTS)
    np.testing.assert_array_equal(points[:, rest], before[:, rest])


@given(opening=st.floats(0.001, 0.3), odds=st.floats(-9, 9), seed=st.integers(0, 99))
def test_lids_come_closer_and_never_cross(opening, odds, seed):
    points, crops = eyes(opening, seed)
    before = points.copy()
    close_shut_eyes(points, crops, always(odds), SPAN)
    for now, then in zip(points, before, strict=True):
        assert -1e-6 < opening_of(now) <= opening_of(then) + 1e-6
    if odds <= -0.5:
        np.testing.assert_array_equal(points, before)


@given(seed=st.integers(0, 99), gain=st.floats(0.6, 1.4), shift=st.floats(-0.1, 0.1))
def test_what_the_model_reads_is_not_where_an_eye_lies(seed, gain, shift):
    points, crops = eyes(0.1, seed)
    numbers = numbers_of(points[0], crops[0], SPAN)
    assert numbers.shape == (NUMBERS,) == (len(read_array("shut_eyes.npy")) - 1,)
    moved = points[0] * gain + np.float32(shift)
    places = slice(0, 2 * len(EYE) + 1)
    np.testing.assert_allclose(
        numbers_of(moved, crops[0], SPAN)[places], numbers[places], atol=1e-3
    )


def test_the_eyes_of_the_portrait_stay_open(monkeypatch):
    (face,) = find_faces(portrait())
    monkeypatch.setattr(face_nets, "close_shut_eyes", lambda *_: None)
    np.testing.assert_array_equal(find_faces(portrait())[0].points_px, face.points_px)


@pytest.fixture(scope="module")
def openings():
    """(frames, 2 eyes, 2): openings in the sample video, as the net reads them and at the end."""
    seen = []

    def note(points, *rest):
        before = list(map(opening_of, points))
        close_shut_eyes(points, *rest)
        seen.append(list(zip(before, map(opening_of, points), strict=True)))

    with pytest.MonkeyPatch.context() as patch, av.open(str(SAMPLES / "in.mp4")) as container:
        patch.setattr(face_nets, "close_shut_eyes", note)
        paint, rows = Painter(ready_look("cat-eye").look), []
        for number, frame in enumerate(container.decode(video=0)):
            if number == 150:
                break
            paint(frame.to_ndarray(format="rgb24"), number / 30)
            rows.append(seen[-1])
    return np.array(rows)


def test_blinks_of_the_sample_video_shut_the_eyes(openings):
    """Nothing was trained on this video. Each of its three blinks is shut in at least one frame."""
    before, now = openings[..., 0], openings[..., 1]
    assert before.min() > 0.1
    blinks = [range(20, 30), range(70, 80), range(117, 127)]
    assert all(now[blink].min() < 0.01 for blink in blinks)
    np.testing.assert_array_equal(now[before > 0.2], before[before > 0.2])
