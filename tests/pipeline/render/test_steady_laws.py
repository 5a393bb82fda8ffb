"""What holds for every kind: borders do not shake, and thin lines do not crawl."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from layers import SLOTS, layer_weight, lipstick, shadow
from makeup import close_up, product
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead
from people import frame_of
from plain_scenes import plain_scene, turned_head

IOD_PX, SIZE = 130, (320, 360)
JITTER = 0.0004  # of the eyes' distance: that of smoothed points of a still face


def liner(thickness=0.14, **shape):
    return Layer("eyeliner", product(), {"thickness": thickness, **shape})


def head_at(offset_xy=(0, 0), iod_px=IOD_PX):
    return turned_head(0, iod_px, (160 + offset_xy[0], 160 + offset_xy[1]))


LIPSTICK = lipstick()
LAYERS = {slot: shadow(slot) for slot in SLOTS} | {
    "line": liner(),
    "wing": liner(wing=0.3),
    "lower line": liner(lower=1.0),
    "smudged": liner(0.3, wing=0.3, lower=0.6, softness=0.5),
}
for name in set(KINDS) - {"lipstick", "eyeshadow", "eyeliner"}:
    LAYERS[name] = Layer(name, replace(product(), edge_softness=0.8))  # as in all their finishes


def shake(scenes, layer):
    """By how many px the borders of a layer move, rms over scenes, mean over borders."""
    weights = np.stack([layer_weight(scene, layer) for scene in scenes])
    steep = np.hypot(*np.gradient(weights.mean(0)))
    assert steep.sum() > 10
    return weights.std(0).sum() / steep.sum()


@cache
def jittered():
    rng = np.random.default_rng(0)
    noise = np.zeros((24, 478, 3))
    noise[..., :2] = rng.normal(0, JITTER * IOD_PX, (24, 478, 2))
    return [plain_scene(head_at() + one, SIZE) for one in noise]


@pytest.mark.parametrize("name", LAYERS)
def test_jitter_shakes_borders_no_more_than_those_of_lips(name):
    assert 0 < shake(jittered(), LAYERS[name]) <= shake(jittered(), LIPSTICK)


@cache
def still_video():
    """A still face under noise of sigma 4, followed and smoothed as in a video."""
    rng = np.random.default_rng(5)
    still = close_up(0, (180, 40, 460, 330))[0].repeat(2, 0).repeat(2, 1)
    noisy = [np.clip(still + rng.normal(0, 4, still.shape), 0, 255) for _ in range(40)]
    find, smooth, build = FindFaces(), SmoothAhead(), BuildScene()
    items = [smooth(find(frame_of(rgb.astype(np.uint8), at))) for at, rgb in enumerate(noisy)]
    items = [item for item in (*items, *smooth.drain()) if item is not None]
    assert len(items) == 40 and all(len(item.faces) == 1 for item in items)
    return [build(item) for item in items[8:]]  # the first few frames settle


@pytest.mark.parametrize("name", [*LAYERS, "hairline"])
def test_a_still_face_shakes_borders_hardly_more_than_lips(name):
    """Above the lips a highlighter follows single points, but lipstick follows a whole mask."""
    layer = liner(0.03) if name == "hairline" else LAYERS[name]
    most = 1.25 if name == "highlighter" else 1.0
    assert 0 < shake(still_video(), layer) <= most * shake(still_video(), LIPSTICK)


def total(layer, points=None):
    scene = plain_scene(head_at() if points is None else points, SIZE)
    return float(layer_weight(scene, layer).sum())


@pytest.mark.parametrize("iod_px", [30, 60, 130])
@pytest.mark.parametrize("shape", [{}, {"wing": 0.3, "lower": 0.6}], ids=["line", "wing"])
def test_a_line_grows_steadily_with_its_thickness(iod_px, shape):
    thickness = np.linspace(0.01, 0.4, 14)
    points = head_at(iod_px=iod_px)
    totals = np.array([total(liner(one, **shape), points) for one in thickness])
    assert (np.diff(totals) > 0).all() and totals[0] > 0
    # growth is the same below one pixel: no step where the line begins to be seen
    assert np.diff(totals).max() < 4 * np.median(np.diff(totals))


@pytest.mark.parametrize("iod_px", [30, 130])
@pytest.mark.parametrize("thickness", [0.02, 0.05, 0.14])
def test_a_line_is_as_strong_wherever_it_lies_between_pixels(iod_px, thickness):
    layer = liner(thickness, lower=1.0)
    totals = [
        total(layer, head_at((x / 5, y / 7), iod_px))
        for x, y in zip(range(5), range(5), strict=True)
    ]
    assert np.ptp(totals) < 0.06 * np.mean(totals)  # 0.05 where the eye is 9 px wide


def test_a_line_thinner_than_a_pixel_is_faint_and_not_broken():
    scene = plain_scene(head_at(iod_px=60), SIZE)
    weight = layer_weight(scene, liner(0.05))
    assert 0.05 * 0.36 * 0.31 * 60 < 0.4  # px
    outer, inner = scene.faces[0].face.points_px[[33, 133], 0].round().astype(int)
    columns = weight[:, outer + 3 : inner - 3].sum(0)
    assert columns.min() > 0 and weight.max() < 0.95
    assert np.abs(np.diff(columns)).max() < 0.25 * columns.mean()
