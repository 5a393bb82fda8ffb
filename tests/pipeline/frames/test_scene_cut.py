"""Cuts are detected; flashes, fades, pans and noise are not cuts."""

import numpy as np
import pytest
from makeup_video.pipeline.frames.scene_cut import CutDetector
from people import clip, portrait


def luma(rgb8: np.ndarray) -> np.ndarray:
    return rgb8.astype(np.float32).mean(2).astype(np.uint8)


def cuts(planes, bit_depth=8) -> list[int]:
    is_cut = CutDetector()
    return [index for index, plane in enumerate(planes) if is_cut(plane, bit_depth)]


def other() -> np.ndarray:
    y, x = np.mgrid[0:360, 0:640]
    return (128 + 100 * np.sin(x / 40) * np.cos(y / 30)).astype(np.uint8)


def test_a_talking_head_has_no_cut():
    assert cuts(luma(frame) for frame in clip()) == []


def test_another_scene_is_a_cut_where_it_begins():
    head = [luma(frame) for frame in clip(6)]
    assert cuts([*head, other(), other(), *head]) == [6, 8]


@pytest.mark.parametrize("bit_depth", [10, 12])
def test_deeper_planes_show_the_same_cuts(bit_depth):
    planes = [luma(clip(2)[0]), luma(clip(2)[1]), other()]
    deep = [plane.astype(np.uint16) << (bit_depth - 8) for plane in planes]
    assert cuts(deep, bit_depth) == [2]


@pytest.mark.parametrize("bit_depth", [8, 10, 12])
@pytest.mark.parametrize("sigma", [4, 12, 24])
def test_grain_is_no_cut_however_even_the_scene(bit_depth, sigma):
    rng = np.random.default_rng(0)
    y, x = np.mgrid[0:720, 0:1280]
    for depth in (0, 3, 6):
        scene = 110 + depth * np.sin(x / 150) * np.cos(y / 90)
        noisy = [scene + rng.normal(0, sigma, scene.shape) for _ in range(4)]
        codes = [np.clip(n, 0, 255) * 2 ** (bit_depth - 8) for n in noisy]
        dtype = np.uint8 if bit_depth == 8 else np.uint16
        assert cuts([c.astype(dtype) for c in codes], bit_depth) == []


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


@pytest.mark.parametrize("shade", [16, 235])
def test_uniform_frames_are_no_cuts_and_hide_none(shade):
    even = np.full((360, 640), shade, np.uint8)
    head = [luma(frame) for frame in clip(6)]
    assert cuts([even, *head[:3], even, *head[3:], even, even]) == []
    assert cuts([*head[:3], even, other(), other()]) == [4]


@pytest.mark.parametrize("size", [(1, 1), (2, 3), (17, 5), (4320, 7680)])
def test_any_size_will_do(size):
    plane = np.zeros(size, np.uint8)
    assert cuts([plane, plane + 200]) == []
