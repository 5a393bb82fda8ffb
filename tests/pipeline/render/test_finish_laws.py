"""What holds for every finish: the product's own colour on every skin, shine left out."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from laws import lab
from makeup import flat_surface, paint_codes, paint_planes, scene_of, weights_of, white_light
from makeup_video.kernels.colour import SRGB, Coding, decode, encode, rounded, to_linear, to_xyz
from makeup_video.pipeline.faces.find import find_faces_in_frame
from makeup_video.pipeline.look.finishes import FINISHES
from makeup_video.pipeline.look.finishes import product as finished
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.render.product_twin import SkinAxes, material
from people import frame_of, portrait
from skimage.color import deltaE_ciede2000

CODING = Coding(1, True)
SKINS = [(60, 38, 28), (105, 70, 52), (160, 112, 88), (200, 156, 130), (236, 200, 178)]
VIOLET, BLACK = (132, 40, 146), (4, 0, 0)
COLOURS = [VIOLET, BLACK, (180, 0, 46), (190, 130, 110), (110, 20, 60), (20, 60, 160),
           (90, 58, 46), (230, 120, 160), (240, 215, 200), (128, 128, 128)]  # fmt: skip
AXES = SkinAxes(np.eye(2), 150.0)
SIZE = 24


def linear_of(rgb):
    return to_linear(np.array(rgb) / 255, SRGB)


def on_skin(params, skin, spared=0.0, down=0.5):
    """Median light, (3,), of a product on even skin that leans away from the highlight."""
    patch = rounded(encode(linear_of(skin), CODING), CODING)
    luminance = float(decode(patch.astype(float), CODING) @ to_xyz(1)[1])
    surface = flat_surface((SIZE, SIZE), luminance)
    surface.normals[1] = down
    lit = material(params, 1.0, white_light(), AXES, CODING, spared)
    luma = np.full((SIZE, SIZE), patch[0], np.uint8)
    chroma = np.tile(patch[1:, None, None], (1, SIZE, SIZE)).astype(np.float32)
    codes = np.moveaxis(paint_codes(luma, chroma, surface, lit, CODING), 0, -1)
    return np.median(decode(codes.astype(float), CODING), (0, 1))


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.name)
@pytest.mark.parametrize("finish", FINISHES)
def test_opaque_products_show_their_colour(finish, kind):
    for rgb in COLOURS:
        params = replace(finished(rgb, finish, kind.part), opacity=1.0)
        off = [
            float(deltaE_ciede2000(lab(on_skin(params, skin)), lab(linear_of(rgb))))
            for skin in SKINS
        ]
        assert np.median(off) < 3, (rgb, off)


@pytest.mark.parametrize("skin", SKINS, ids=str)
def test_black_matte_eye_shadow_is_black_on_any_skin(skin):
    assert lab(on_skin(finished(BLACK, "matte", "eyes"), skin, 0.2))[0] < 10


@cache
def portrait_scene():
    frame = frame_of(portrait(), pix_fmt="yuv444p", full_range=True)
    return scene_of(frame, find_faces_in_frame(frame)[0].faces, white_light())


def on_lids(rgb, finish, monkeypatch):
    """Lab of the pixels in the middle of the lids of a photo, (N, 3)."""
    scene, look = portrait_scene(), Look(eyes=finished(rgb, finish, "eyes"))
    middle = weights_of(scene, look, monkeypatch) > 0.9
    codes = np.stack(paint_planes(scene, look), axis=-1)[middle].astype(float)
    return lab(decode(codes, scene.coding))


def test_black_matte_eye_shadow_is_black_on_a_photo(monkeypatch):
    light = on_lids(BLACK, "matte", monkeypatch)[:, 0]
    assert np.median(light) < 10
    assert np.quantile(light, 0.99) < 35  # no crumbs between the lashes, no streak in the crease


@pytest.mark.parametrize("finish", ["shimmer", "metallic", "satin"])
def test_violet_eye_shadow_stays_violet_on_a_photo(finish, monkeypatch):
    _, a, b = np.median(on_lids(VIOLET, finish, monkeypatch), axis=0)
    _, own_a, own_b = lab(linear_of(VIOLET))
    turned = np.degrees(np.angle(complex(a, b) / complex(own_a, own_b)))
    # the skin under a film that is not fully opaque still turns the hue
    assert abs(turned) < 10 and np.hypot(a, b) > 0.5 * np.hypot(own_a, own_b)
