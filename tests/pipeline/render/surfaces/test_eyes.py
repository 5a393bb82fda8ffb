"""Slots of eyeshadow: where they lie, and how they follow the lid."""

from dataclasses import replace

import cv2
import heads
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from layers import SLOTS, UPPER_SLOTS, densities, shadow, surface_weight
from makeup import close_up, inside, true_face, white_light
from makeup_video.pipeline.faces.face import moved, resized
from makeup_video.pipeline.faces.topology import BROW, EYE, EYE_CONTOUR, RIGHT_BROW, RIGHT_EYE
from makeup_video.pipeline.render.surfaces.both_eyes import OUTWARDS
from makeup_video.pipeline.render.surfaces.eyes import EYES
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces, light_on_lid
from makeup_video.pipeline.render.surfaces.surface import Edge
from makeup_video.pipeline.render.surfaces.unfolded import STEPS
from reference_photos import face as found_face

HW = (220, 200)


def weights(points, slot="lid", softness=0.5, hw=HW):
    surfaces, layer = lid_surfaces(true_face(points)), shadow(slot, softness)
    return np.stack([surface_weight(surface, layer, hw) for surface in surfaces])


def turned(points, degrees, scale=1.0):
    angle = np.radians(degrees)
    spin = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return (points - (100, 60)) @ spin.T + (100, 60)


@pytest.mark.parametrize("slot", SLOTS)
@pytest.mark.parametrize("softness", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("number", [0, 60])
def test_slots_lie_around_the_eye_and_below_the_brow(slot, softness, number):
    _, points = close_up(number)
    for weight, contour, eye in zip(
        weights(points, slot, softness),
        (EYE_CONTOUR, RIGHT_EYE[:16]),
        (EYE, RIGHT_EYE),
        strict=True,
    ):
        assert 0.5 < weight.max() <= 1 and weight.min() == 0
        assert weight[inside(points[contour], HW, 0.7)].max() == 0
        rows = np.flatnonzero((weight > 0.2).any(1))
        assert rows[0] > points[eye[42:46], 1].min() - 10
        if slot in UPPER_SLOTS:
            assert rows[-1] < points[eye[:16], 1].max()


@pytest.mark.parametrize("degrees", [0, 25, 90])
@pytest.mark.parametrize("pixel_aspect", [0.5, 8 / 9, 4 / 3, 2.0])
def test_lids_are_the_same_in_pixels_of_any_shape(pixel_aspect, degrees):
    """As in HDV and DV: the viewer sees each pixel as wide as its aspect ratio says."""
    shown = found_face()
    angle = np.radians(degrees)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0]])
    shown = moved(shown, turn)
    stored = resized(shown, 1 / pixel_aspect, 1)
    for lid, wanted in zip(lid_surfaces(stored), lid_surfaces(shown), strict=True):
        np.testing.assert_allclose(lid.up, wanted.up, atol=2e-3)
        places = wanted.grid.places()
        places[0] = (places[0] + 0.5) / pixel_aspect - 0.5
        np.testing.assert_allclose(lid.grid.places(), places, atol=2e-3)


def middle_of(weight):
    y, x = np.mgrid[: weight.shape[0], : weight.shape[1]]
    return np.array([(x * weight).sum(), (y * weight).sum()]) / weight.sum()


def test_slots_are_where_their_names_say():
    _, points = close_up()
    by_slot = {slot: weights(points, slot)[0] for slot in SLOTS}
    x, y = np.array([middle_of(by_slot[slot]) for slot in SLOTS]).T
    x, y = dict(zip(SLOTS, x, strict=True)), dict(zip(SLOTS, y, strict=True))
    assert y["brow_bone"] < y["crease"] < y["lid"] < y["under"]
    assert by_slot["full"].sum() > 1.5 * max(by_slot["lid"].sum(), by_slot["outer"].sum())
    columns = {slot: (by_slot[slot] > 0.3).any(0).sum() for slot in SLOTS}
    assert columns["inner"] < columns["outer"] < columns["lid"]
    outer, inner = points[33, 0], points[133, 0]
    assert abs(y["inner"] - points[133, 1]) < 0.2 * abs(outer - inner)
    assert (x["outer"] - x["lid"]) * (outer - inner) > 0
    assert (x["lid"] - x["inner"]) * (outer - inner) > 0


def test_one_eye_is_the_mirror_of_the_other():
    _, points = close_up()
    mirrored = points.copy()
    left, right = np.concatenate([EYE, BROW]), np.concatenate([RIGHT_EYE, RIGHT_BROW])
    mirrored[left], mirrored[right] = points[right], points[left]
    mirrored[:, 0] = HW[1] - 1 - mirrored[:, 0]
    original, mirror_image = weights(points), weights(mirrored)[:, :, ::-1]
    for eye, other in ((0, 1), (1, 0)):
        # `up` differs a little
        np.testing.assert_allclose(original[eye], mirror_image[other], atol=0.08)


def test_a_closing_lid_takes_the_shadow_down_with_it():
    (_, opened), (_, closed) = close_up(60), close_up(75)
    reach = []
    for points in (opened, closed):
        middle = points[[33, 133]].mean(0)
        weight = weights(points)[0]
        reach.append(np.flatnonzero(weight[:, round(middle[0])] > 0.3).max() - middle[1])
    assert reach[1] > reach[0] + 2


@settings(max_examples=30, deadline=None)
@given(st.floats(-180, 180), st.floats(0.3, 3), st.floats(0, 1), st.sampled_from(SLOTS))
def test_slots_turn_with_the_face_and_stay_within_reach(degrees, scale, softness, slot):
    _, points = close_up()
    points = turned(points, degrees, scale)
    for surface in lid_surfaces(true_face(points)):
        most = 0.0
        for side, density in densities(surface, shadow(slot, softness)):
            low, high = np.array(side.reach(Edge(softness), density))
            origin = np.floor(low).astype(int) - 15
            out = np.zeros(tuple(np.ceil(high - low).astype(int)[::-1] + 30), np.float32)
            side.weigh(out, tuple(origin), Edge(softness), density)
            assert np.isfinite(out).all() and out.max() <= 1
            most = max(most, out.max())
            y, x = np.nonzero(out)
            assert (x + origin[0] >= low[0] - 1.5).all() and (x + origin[0] <= high[0] + 1.5).all()
            assert (y + origin[1] >= low[1] - 1.5).all() and (y + origin[1] <= high[1] + 1.5).all()
            # nothing lies at the grid's own border; otherwise the slot would be cut off there
            on_skin = density * ((side.lash_px if side.is_upper else side.below_px) > 0)
            border = np.concatenate([on_skin[0], on_skin[-1], on_skin[:, 0], on_skin[:, -1]])
            assert border.max() < 0.02
        assert most > 0.3


@settings(max_examples=30, deadline=None)
@given(st.floats(-180, 180), st.floats(-2, 2))
def test_normals_are_finite_and_face_the_viewer_on_any_face(degrees, lean):
    _, points = close_up()
    points = turned(points, degrees)
    points = np.column_stack([points, lean * points[:, 0] - 3 * lean * points[:, 1]])
    shaken = points + np.random.default_rng(1).normal(0, 6, points.shape)
    for variant in (points, points * (0.2, 1, 1), shaken, 0 * points + 50):
        for region in lid_surfaces(heads.face(variant)):
            assert np.isfinite(region.normals).all() and np.isfinite(region.up).all()
            assert (np.square(region.normals).sum(0) < 1).all()


@settings(max_examples=20, deadline=None)
@given(st.floats(-180, 180))
def test_lids_lie_on_a_ball(degrees):
    _, points = close_up()
    for lid in lid_surfaces(true_face(turned(points, degrees))):
        lashes, middle, crease = facing(lid)
        assert crease < middle - 0.1 < lashes - 0.2


def test_lids_of_a_face_from_the_front_face_up_a_little():
    for lid in lid_surfaces(found_face()):
        lashes, middle, _ = facing(lid)
        assert -0.4 < middle < 0 < lashes


def test_skin_below_the_eye_does_not_turn_in_a_blink():
    """As the eye shuts, its upper lashes come down to the lower ones."""
    _, points = close_up()
    shut = points.copy()
    for eye in (EYE, RIGHT_EYE):
        upper, lower = eye[[13, 12, 11]], eye[[3, 4, 5]]
        shut[upper] = points[lower] - (0, 1)
    for before, after in zip(
        lid_surfaces(true_face(points)), lid_surfaces(true_face(shut)), strict=True
    ):
        under = (before.below_px > 3) & (after.below_px > 3)
        under[:, np.abs(OUTWARDS) > 0.4] = False
        assert under.sum() > 20
        np.testing.assert_allclose(after.normals[1][under], before.normals[1][under], atol=0.1)


def facing(lid):
    """How far a lid faces down: at its lashes, in its middle and at its crease."""
    above_pupil = np.abs(OUTWARDS) < 0.3
    up, down = lid.up[:, above_pupil], lid.normals[1][:, above_pupil]
    return [down[np.abs(up - height) < 0.15].mean() for height in (0, 0.5, 1)]


def test_eyes_too_narrow_to_be_seen_are_left_out():
    _, points = close_up()
    one_eyed = points.copy()
    one_eyed[EYE] = points[EYE].mean(0) + (points[EYE] - points[EYE].mean(0)) * (0.05, 1)
    one_eyed[[33, 133], 1] = one_eyed[33, 1]
    assert len(lid_surfaces(true_face(points))) == 2
    assert len(lid_surfaces(true_face(one_eyed))) == 1


def test_the_light_of_a_lid_is_measured_on_skin():
    """A bright eyeball does not count."""
    _, points = close_up()
    for region, contour in zip(
        lid_surfaces(true_face(points)), (EYE_CONTOUR, RIGHT_EYE[:16]), strict=True
    ):
        eyeball = inside(points[contour], HW, 1).astype(np.float32)
        back = cv2.invertAffineTransform(region.grid.to_px)
        size_wh = region.up.shape[::-1]
        luminance = 0.2 + 5 * cv2.warpAffine(eyeball, back, size_wh, flags=cv2.INTER_NEAREST)
        light, mean = light_on_lid(region, luminance)
        assert light.shape == region.up.shape
        assert mean == pytest.approx(0.2) and np.ptp(light) < 1e-3


def test_lids_lie_in_half_of_the_shade_that_they_show():
    light = replace(white_light(), skin=0.4)
    even = 0.75 * 0.4  # lids are darker than the face: the brow shades them
    lids = np.geomspace(1e-4, 2, 200)
    shades = [EYES.shade(light, float(even * lid)) for lid in lids]
    assert np.diff(shades).min() >= 0 and max(shades) == 1
    assert EYES.shade(light, even / 4) == pytest.approx(0.5)
    assert 0 < shades[0] < 0.15  # nothing shines behind sunglasses
    assert EYES.shade(replace(light, skin=0.0), even) == 1


@pytest.mark.parametrize("shut", [(EYE,), (EYE, RIGHT_EYE)])
def test_only_lids_that_shut_unfold(shut):
    _, points = close_up()
    for eye in shut:
        points[eye[9:16]] = points[eye[7:0:-1]]  # upper lashes on the lower ones
    steps = lid_surfaces(true_face(points))[0].both.steps
    assert steps == [STEPS if any(eye is one for one in shut) else 0 for eye in (EYE, RIGHT_EYE)]
