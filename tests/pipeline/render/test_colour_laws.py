"""What holds for every look: which bytes change, and in which colour."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from laws import lab, same
from layers import everything, layer_lists, looks
from makeup import (
    BARE,
    FLAT,
    LAYOUTS,
    close_up,
    close_up_scene,
    copied,
    flat_surface,
    lights,
    lit_of,
    paint_codes,
    paint_planes,
    params,
    product,
    scene_of,
    tagged,
    true_face,
    weights_of,
    white_light,
)
from makeup_video.kernels.colour import (
    HLG,
    PQ,
    SRGB,
    Coding,
    decode,
    encode,
    matrices,
    rounded,
    to_encoded,
    to_linear,
    to_xyz,
)
from makeup_video.kernels.material_twin import made_up, skin_at
from makeup_video.kernels.paint_twin import on_pixels
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.render.product_twin import SkinAxes, material
from people import frame_of
from skimage.color import deltaE_ciede2000

BOTH = Look(lips=product(), eyes=product(red=0, green=90, blue=40))
FACING = SkinAxes(np.eye(2), 100.0)
fewer_examples = settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)


def odd_scene(pix_fmt, tags=None):
    """A close-up of odd size on which the face is cut off on the right and below."""
    rgb8, points = close_up(box=(231, 83, 384, 270))
    frame = frame_of(rgb8[: 173 + 8, :113], pix_fmt=pix_fmt)
    frame = tagged(frame, tags) if tags else frame
    return scene_of(frame, (true_face(points),), white_light())


@fewer_examples
@given(looks(**BARE))
def test_without_opacity_gloss_and_reflection_no_byte_changes(look):
    scene = close_up_scene("yuv420p")
    assert same(paint_planes(scene, look), copied(scene.frame))


@fewer_examples
@given(layer_lists(), st.floats(0, 1))
def test_bare_looks_change_no_byte(layers, strength):
    scene = close_up_scene("yuv420p")
    weak = [replace(layer, strength=0.0) for layer in layers]
    for bare in (Look(layers, strength=0.0), Look(weak, strength), Look((), strength)):
        assert same(paint_planes(scene, bare), copied(scene.frame))


def unpainted(scene, look, monkeypatch):
    """Return for each plane a mask of the samples that no weight touches."""
    weight = weights_of(scene, look, monkeypatch) > 0
    across, down = scene.frame.chroma
    high, wide = (-(-n // step) for n, step in zip(weight.shape, (down, across), strict=True))
    padded = np.zeros((high * down, wide * across), bool)
    padded[: weight.shape[0], : weight.shape[1]] = weight
    touched = padded.reshape(high, down, wide, across).any((1, 3))
    masks = [~weight] + [~touched] * (len(scene.frame.planes) - 1)
    return [
        np.broadcast_to(mask[..., None] if plane.ndim == 3 else mask, plane.shape)
        for mask, plane in zip(masks, scene.frame.planes, strict=True)
    ]


@pytest.mark.parametrize("pix_fmt", LAYOUTS)
@pytest.mark.parametrize("cut", [False, True], ids=["whole", "odd and cut off"])
def test_nothing_changes_outside_the_mask(pix_fmt, cut, monkeypatch):
    scene = odd_scene(pix_fmt) if cut else close_up_scene(pix_fmt)
    glossy = everything(gloss=1e300, reflection=1, edge_softness=1, shimmer=1)
    for look in (BOTH, glossy):
        bare = unpainted(scene, look, monkeypatch)
        before, after = copied(scene.frame), paint_planes(scene, look)
        for old, new, mask in zip(before, after, bare, strict=True):
            np.testing.assert_array_equal(new[mask], old[mask])
            assert (new != old).any() and mask.any()


@fewer_examples
@given(layer_lists())
def test_no_look_changes_pixels_far_from_lips_and_eyes(layers):
    """Blush and other kinds of the whole face are left out."""
    look = Look(layer for layer in layers if KINDS[layer.kind].region != "face")
    scene = close_up_scene("yuv420p")
    points = scene.faces[0].face.points_px[:, :2]
    nose, chin, brow = points[5, 1], points[152, 1], points[10, 1]
    before, after = copied(scene.frame), paint_planes(scene, look)
    changed = np.argwhere(before[0] != after[0])
    if len(changed):
        assert brow < changed[:, 0].min() and changed[:, 0].max() < chin
        assert points[:, 0].min() < changed[:, 1].min() and changed[:, 1].max() < points[:, 0].max()
        assert not (abs(changed[:, 0] - nose) < 3).any()


@fewer_examples
@given(params(opacity=0.5, **FLAT), st.sampled_from([SRGB, PQ]))
def test_more_opacity_moves_a_frame_steadily_to_the_product(p, transfer):
    tags = ColourTags(1, 1, 1 if transfer == SRGB else transfer, 1)
    rgb8, points = close_up()
    frame = tagged(frame_of(rgb8, pix_fmt="yuv444p10le"), tags)
    scene = scene_of(frame, (true_face(points),), white_light())
    coding = scene.coding
    painted_rgb = []
    for opacity in (0, 0.25, 0.5, 0.75, 1):
        planes = paint_planes(scene, Look(lips=replace(p, opacity=opacity)))
        codes = np.stack(planes, axis=-1).astype(float)
        painted_rgb.append(codes @ matrices(coding)[0][:, :3].T)
    distance = np.abs(np.stack(painted_rgb) - painted_rgb[-1])
    unit = 2.5 * np.abs(matrices(coding)[0][:, :3]).sum(1)  # all three codes are rounded
    clipped = (codes[..., 0] == 0) | (codes == coding.max_code).any(-1)
    rise = np.minimum(np.diff(distance, axis=0), distance[1:])[:, ~clipped]
    assert (rise <= unit).all()


@fewer_examples
@given(
    looks(), lights(), st.sampled_from([SRGB, PQ, HLG]), st.sampled_from([0, 64, 500, 940, 1023])
)
def test_uniform_frames_of_any_code_are_painted_without_nan(look, light, transfer, code):
    rgb8, points = close_up()
    frame = tagged(frame_of(rgb8, pix_fmt="yuv420p10le"), ColourTags(9, 1, transfer, 9))
    for plane in frame.writable_planes():
        plane[:] = code
    with np.errstate(invalid="raise", divide="raise"):
        scene = scene_of(frame, (true_face(points),), light)
        planes = paint_planes(scene, look)
    assert max(plane.max() for plane in planes) <= 1023
    for lit in lit_of(scene.faces[0]):
        assert np.isfinite(lit.shading).all() and np.isfinite(lit.mean)
        assert np.isfinite(lit.surface.normals).all()


SAME_PICTURE = [
    Coding(matrix, full, SRGB, primaries, depth)
    for matrix, primaries in ((1, 1), (6, 1), (9, 9), (6, 6))
    for full in (False, True)
    for depth in (8, 10)
]
SURFACE = flat_surface((12, 9), 0.257)  # luminance of the picture's skin


def srgb_of(codes, coding):
    """Return sRGB-encoded R'G'B' of codes in any coding."""
    linear = decode(codes, coding) @ np.linalg.solve(to_xyz(1), to_xyz(coding.primaries)).T
    return to_encoded(linear, SRGB)


def codes_of(srgb_linear, coding):
    linear = srgb_linear @ np.linalg.solve(to_xyz(coding.primaries), to_xyz(1)).T
    return encode(linear, coding)


@settings(max_examples=60, deadline=None)
@given(params(**FLAT), st.integers(0, 99), st.sampled_from([1.0, 1.2]))
def test_the_same_picture_looks_the_same_in_every_coding(p, seed, brightest):
    rng = np.random.default_rng(seed)
    picture = np.array([0.42, 0.22, 0.14]) * rng.uniform(0.5, brightest, (9, 12, 1))
    exact, by_kernel = {}, {}
    for coding in SAME_PICTURE:
        lit = material(p, 1.0, white_light(), FACING, coding)
        exact[coding] = srgb_of(
            painted_without_rounding(codes_of(picture, coding), lit, coding), coding
        )
        by_kernel[coding] = srgb_of(
            painted_by_kernel(codes_of(picture, coding), lit, coding), coding
        )
    first = exact[SAME_PICTURE[0]]
    for coding, rgb in exact.items():
        # an eighth of an 8-bit code: the light's colour is stored as float32
        assert np.abs(rgb - first).max() < (1e-6 if coding.primaries == 1 else 5e-4), coding
    for coding, rgb in by_kernel.items():
        bright = (first > 0.1).all(-1) & (first < 0.95).all(-1)  # darker codes are coarser in light
        step = np.abs(matrices(coding)[0][:, :3]).sum(1).max()  # one code in each plane
        # rounded before and after; BT.2020's primaries spread an error over the others
        assert (
            np.abs(rgb - exact[coding])[bright].max(initial=0)
            < (2.5 if coding.primaries == 1 else 5) * step
        ), coding


def painted_without_rounding(codes, lit, coding):
    """Paint codes in floating point, without any rounding."""
    coarse, nx, ny, *exposed = on_pixels(SURFACE)
    skin = skin_at(coarse, SURFACE.mean, nx, ny, SURFACE.environment.linear(), lit, *exposed)
    return encode(made_up(decode(codes, coding), SURFACE.weight, coarse, coarse, skin, lit), coding)


def painted_by_kernel(codes, lit, coding):
    """Paint codes with the kernel, from and to whole codes, 4:4:4."""
    whole = np.moveaxis(rounded(codes, coding), -1, 0)
    luma = whole[0].astype(np.uint8 if coding.bit_depth == 8 else np.uint16)
    return np.moveaxis(paint_codes(luma, whole[1:], SURFACE, lit, coding), 0, -1)


@pytest.mark.parametrize("matrix", [1, 5, 9])
@pytest.mark.parametrize("full_range", [False, True])
def test_a_frame_of_any_coding_is_painted_alike(matrix, full_range):
    """The primaries stay those of BT.709."""
    rgb8, points = close_up()
    srgb = []
    for some_matrix, full in ((1, False), (matrix, full_range)):
        frame = frame_of(rgb8, pix_fmt="yuv444p", matrix=some_matrix, full_range=full)
        scene = scene_of(frame, (true_face(points),), white_light())
        codes = np.stack(paint_planes(scene, BOTH), axis=-1).astype(float)
        srgb.append(255 * to_encoded(decode(codes, scene.coding), SRGB).clip(0, 1))
    difference = np.abs(srgb[0] - srgb[1])
    # Both frames round from 8 bits to 8 bits. Single pixels differ more: one code may decide
    # whether a dark pixel counts as a lash.
    assert difference.mean() < 1.2 and np.quantile(difference, 0.998) < 6


_RNG = np.random.default_rng(8)
COLOURS = [
    (0, 0, 0), (255, 255, 255), (0, 0, 255), (255, 255, 0), (255, 0, 0), (0, 255, 0),
    (0, 255, 255), (255, 0, 255), (128, 128, 128), (180, 0, 46), (10, 42, 140), (20, 8, 10),
    *map(tuple, _RNG.integers(0, 256, (38, 3)).tolist()),
]  # fmt: skip


@pytest.mark.parametrize("skin", [(60, 38, 28), (236, 200, 178)], ids=["dark", "light"])
@pytest.mark.parametrize("coding", [Coding(1, True), Coding(1), Coding(6)], ids=str)
def test_the_painted_colour_is_the_products_colour(skin, coding):
    """8 bits, 4:4:4, light and dark skin. The tolerance allows for rounding to 8 bits, which alone
    may shift dark colours in limited range by more than 1."""
    patch = rounded(codes_of(to_linear(np.array(skin) / 255, SRGB), coding), coding)
    luminance = float(decode(patch.astype(float), coding) @ to_xyz(1)[1])
    differences = []
    for rgb in COLOURS:
        red, green, blue = rgb
        lit = material(product(red=red, green=green, blue=blue), 1, white_light(), FACING, coding)
        luma = np.full((2, 2), patch[0], np.uint8)
        chroma = np.tile(patch[1:, None, None], (1, 2, 2)).astype(np.float32)
        got = paint_codes(luma, chroma, flat_surface((2, 2), luminance), lit, coding)[:, 0, 0]
        wanted = to_linear(np.array(rgb) / 255, SRGB)
        best = rounded(codes_of(wanted, coding), coding)
        difference, least = (
            float(deltaE_ciede2000(lab(decode(codes.astype(float), coding)), lab(wanted)))
            for codes in (got, best)
        )
        differences.append((difference, least, rgb))
    worst = sorted(differences)[-5:]
    assert all(found < max(1.0, least + 0.05) for found, least, _ in differences), worst
    if coding.full_range:
        assert worst[-1][0] < 1.0
