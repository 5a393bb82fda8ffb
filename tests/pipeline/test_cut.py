"""Cuts are seen; flashes, fades, pans and noise are none."""

import numpy as np
import pytest
from makeup_video.pipeline.cut import CutDetector
from people import clip, portrait


def luma(rgb8: np.ndarray) -> np.ndarray:
    return rgb8.astype(np.float32).mean(2).astype(np.uint8)


def cuts(planes) -> list[int]:
    is_cut = CutDetector()
    return [at for at, plane in enumerate(planes) if is_cut(plane)]


def other() -> np.ndarray:
    y, x = np.mgrid[0:360, 0:640]
    return (128 + 100 * np.sin(x / 40) * np.cos(y / 30)).astype(np.uint8)


def test_a_talking_head_has_no_cut():
    assert cuts(luma(frame) for frame in clip()) == []


def test_another_scene_is_a_cut_where_it_begins():
    head = [luma(frame) for frame in clip(6)]
    assert cuts([*head, other(), other(), *head]) == [6, 8]


def test_sixteen_bit_planes_cut_alike():
    planes = [luma(clip(2)[0]), luma(clip(2)[1]), other()]
    assert cuts([plane.astype(np.uint16) << 2 for plane in planes]) == [2]


@pytest.mark.parametrize("gain", [0.3, 1.6])
def test_a_flash_or_a_dimmed_light_is_no_cut(gain):
    head = [luma(frame) for frame in clip(6)]
    lit = np.clip(head[3] * gain, 0, 255).astype(np.uint8)
    assert cuts([*head[:3], lit, *head[3:]]) == []


def test_noise_and_a_pan_are_no_cuts():
    wide = np.repeat(luma(portrait()), 1, axis=1)
    rng = np.random.default_rng(0)
    pan = [wide[:, shift : shift + 300] for shift in range(0, 160, 8)]
    noisy = [np.clip(p + rng.normal(0, 12, p.shape), 0, 255).astype(np.uint8) for p in pan]
    assert cuts(noisy) == []


def test_black_frames_before_a_scene_end_there():
    black = np.full((360, 640), 16, np.uint8)
    assert cuts([black, black, other(), other(), black]) == [2, 4]


@pytest.mark.parametrize("size", [(1, 1), (2, 3), (17, 5), (4320, 7680)])
def test_any_size_will_do(size):
    plane = np.zeros(size, np.uint8)
    assert cuts([plane, plane + 200]) == []
