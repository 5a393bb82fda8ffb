"""Painting at half size: the same result in all layouts and odd sizes; other bytes are kept."""

from dataclasses import replace

import av
import cv2
import numpy as np
import pytest
from layers import jobs
from makeup import LAYOUTS, close_up, product, scene_of, tagged, true_face, weights_of, white_light
from makeup_video.kernels.planes import Rect
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.render import composite as composite_module
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.half_resolution import SmallPlanes, small_size
from people import frame_of

BOTH = Look(
    lips=product(gloss=0.6, gloss_roughness=0.2),
    eyes=product(red=0, green=90, blue=140, opacity=0.7),
)


def large_scene(pix_fmt="yuv420p", size_wh=(600, 660)):
    rgb8, points = close_up()
    scale = np.array(size_wh) / rgb8.shape[1::-1]
    large = cv2.resize(rgb8, size_wh, interpolation=cv2.INTER_CUBIC)
    face = true_face((points + 0.5) * scale - 0.5)
    return scene_of(frame_of(large, pix_fmt=pix_fmt), (face,), white_light())


def painted(scene, level, monkeypatch, look=BOTH):
    monkeypatch.setattr(composite_module, "LARGE_PX", 1)
    frame = scene.frame
    target = Frame(
        av.VideoFrame(frame.width_px, frame.height_px, frame.pix_fmt),
        0,
        frame.time_base,
        frame.tags,
    )
    for new, old in zip(target.writable_planes(), frame.planes, strict=True):
        new[:] = old
    composite = Composite(look)
    composite.level = level
    return [plane.copy() for plane in composite(replace(scene, frame=target)).planes]


@pytest.mark.parametrize("size_wh", [(600, 660), (599, 661)])
@pytest.mark.parametrize("pix_fmt", LAYOUTS)
def test_half_resolution_looks_as_at_full_resolution(pix_fmt, size_wh, monkeypatch):
    if pix_fmt == "nv12" and size_wh[0] % 2:
        size_wh = 600, 660
    scene = large_scene(pix_fmt, size_wh)
    whole, half = (painted(scene, level, monkeypatch) for level in (0, 3))
    unit = 2.0 ** (scene.frame.bit_depth - 8)
    weight = weights_of(scene, BOTH, monkeypatch)
    far = cv2.dilate(weight, np.ones((9, 9), np.uint8)) == 0
    assert (half[0][far] == scene.frame.planes[0][far]).all()
    inside = weight > 0.5
    difference = np.abs(whole[0].astype(int) - half[0])[inside] / unit
    change = np.abs(whole[0].astype(int) - scene.frame.planes[0])[inside] / unit
    assert difference.mean() < 2.0 < 0.2 * change.mean()
    for a, b, bare in zip(whole[1:], half[1:], scene.frame.planes[1:], strict=True):
        assert np.abs(a.astype(int) - b).mean() < 0.15 * np.abs(a.astype(int) - bare).mean()


def test_the_picture_keeps_its_detail(monkeypatch):
    """Fine lines are nearly as strong as on the bare skin, because only the change that the product
    makes is coarse. At full size gloss makes them stronger still."""
    scene = large_scene("yuv444p")
    rng = np.random.default_rng(1)
    scene.frame.writable_planes()[0][:] = np.clip(
        scene.frame.planes[0] + rng.normal(0, 6, scene.frame.planes[0].shape), 20, 230
    )
    inside = weights_of(scene, BOTH, monkeypatch) > 0.9

    def detail(plane):
        blurred = cv2.GaussianBlur(plane.astype(np.float32), (0, 0), 1.5)
        return float((plane - blurred)[inside].std())

    whole, half = (painted(scene, level, monkeypatch)[0] for level in (0, 3))
    assert detail(half) > 0.85 * min(detail(whole), detail(scene.frame.planes[0]))


def test_small_regions_are_painted_at_full_size(monkeypatch):
    scene = large_scene(size_wh=(200, 220))
    whole = painted(scene, 0, monkeypatch)
    monkeypatch.undo()
    composite = Composite(BOTH)
    composite.level = 3
    fresh = large_scene(size_wh=(200, 220))
    for a, b in zip(whole, composite(fresh).planes, strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_face_at_the_border_is_painted_up_to_it(monkeypatch):
    rgb8, points = close_up(box=(220, 80, 331, 237))  # cut through the lips and one eye
    large = cv2.resize(rgb8, None, fx=3, fy=3, interpolation=cv2.INTER_CUBIC)
    frame = frame_of(large, pix_fmt="yuv420p")
    scene = scene_of(frame, (true_face((points + 0.5) * 3 - 0.5),), white_light())
    whole, half = (painted(scene, level, monkeypatch)[0].astype(int) for level in (0, 3))
    bare = scene.frame.planes[0].astype(int)
    last = np.abs(whole - bare)[:, -1] > 20
    assert last.any()
    assert (np.abs(half - bare)[:, -1] > 5)[last].mean() > 0.9


@pytest.mark.parametrize("factor", [2, 4])
def test_codes_stay_within_their_bits(factor):
    planes = tuple(np.full((9, 7), 1020, np.uint16) for _ in range(3))

    def paint(small):
        for plane in small:
            plane[:] = 1023

    window = Rect(0, 0, *small_size((7, 9), factor))
    SmallPlanes(factor).paint(planes, [window], (1, 1), 1023, paint)
    for plane in planes:
        assert (plane == 1023).all()


@pytest.mark.parametrize("factor", [2, 4])
def test_what_is_not_painted_keeps_its_bytes(factor):
    rng = np.random.default_rng(3)
    planes = tuple(
        rng.integers(0, 256, shape, np.uint8) for shape in ((41, 33), (21, 17), (21, 17))
    )
    before = [plane.copy() for plane in planes]
    SmallPlanes(factor).paint(planes, [Rect(4, 2, 4, 8)], (2, 2), 255, lambda small: None)
    for plane, old in zip(planes, before, strict=True):
        np.testing.assert_array_equal(plane, old)


@pytest.mark.parametrize("factor", [2, 4])
@pytest.mark.parametrize("size_wh", [(64, 48), (61, 47)])
def test_an_even_change_is_the_same_at_any_size(factor, size_wh):
    wide, high = size_wh
    halves = -(-high // 2), -(-wide // 2)
    planes = tuple(np.full(shape, 90, np.uint8) for shape in ((high, wide), halves, halves))

    def paint(small):
        for plane in small:
            plane += 7

    window = Rect(0, 0, *small_size(size_wh, factor))
    SmallPlanes(factor).paint(planes, [window], (2, 2), 255, paint)
    assert all((plane == 97).all() for plane in planes)


@pytest.mark.parametrize("size_wh", [(600, 660), (599, 661)])
def test_a_veil_at_a_quarter_looks_as_at_full_size(size_wh, monkeypatch):
    scene = large_scene(size_wh=size_wh)
    look = Look([Layer("blush", product(opacity=0.5, texture_keep=1.0), {"size": 0.2})])
    made = []
    for least in ((10**9, 10**9), (1, 1)):
        monkeypatch.setattr(composite_module, "_VEIL_PX", least[0])
        monkeypatch.setattr(composite_module, "_LARGE_VEIL_PX", least[1])
        made.append(painted(scene, 0, monkeypatch, look)[0].astype(int))
    full, quarter = made
    change = np.abs(full - scene.frame.planes[0])
    assert (full != quarter).any() and (change > 3).sum() > 1000
    assert np.abs(full - quarter)[change > 3].mean() < 0.15 * change[change > 3].mean()


def test_tags_do_not_matter(monkeypatch):
    scene = large_scene("yuv420p")
    full = replace(scene, frame=tagged(scene.frame, replace(scene.frame.tags, range=2)))
    assert (painted(full, 3, monkeypatch)[0] != scene.frame.planes[0]).any()


def test_a_face_of_varying_size_keeps_one_resolution(monkeypatch):
    composite = Composite(BOTH)
    composite.level = 3
    calls = []
    monkeypatch.setattr(composite, "_paint_small", lambda *rest: calls.append(True))
    scenes = [large_scene(size_wh=(size, size * 11 // 10)) for size in (400, 390)]
    areas = []
    for scene in scenes:
        size_wh = scene.frame.width_px, scene.frame.height_px
        rects = [job.rect(size_wh, scene.frame.chroma) for job in jobs(scene, BOTH.layers)]
        areas.append(sum(rect.width * rect.height for rect in rects))
    assert areas[1] < areas[0]
    monkeypatch.setattr(composite_module, "LARGE_PX", areas[0])
    for scene in (scenes[0], scenes[1], scenes[0], scenes[1]):
        composite(scene)
    assert len(calls) == 4
