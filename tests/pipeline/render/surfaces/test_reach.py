"""The window that is painted holds every pixel with weight, and little else."""

import numpy as np
import pytest
from heads import HEAD_PX, face
from makeup_video.pipeline.render.surfaces.eyes import ZONES
from makeup_video.pipeline.render.surfaces.eyes_reference import lid_surfaces
from makeup_video.pipeline.render.surfaces.lips_reference import lips_surface


def weighted_box(region, softness, zone):
    """Return the lowest and the highest (x, y) with weight in a large picture, or None."""
    weight = np.zeros((720, 1280), np.float32)
    region.weigh(weight, (0, 0), softness, {"zone": zone})
    y, x = np.nonzero(weight)
    return (np.array([x.min(), y.min()]), np.array([x.max(), y.max()])) if len(x) else None


@pytest.mark.parametrize("softness", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("zone", list(ZONES))
def test_no_weight_lies_beyond_the_reach(softness, zone):
    for index in range(0, len(HEAD_PX), 60):
        head = face(HEAD_PX[index])
        for region in (lips_surface(head), *lid_surfaces(head)):
            low, high = region.reach(softness, {"zone": zone})
            box = weighted_box(region, softness, zone)
            assert (box[0] >= np.floor(low)).all() and (box[1] <= np.ceil(high)).all()


def test_the_reach_of_a_lid_is_no_more_than_its_zone_needs():
    for region in lid_surfaces(face(HEAD_PX[0])):
        low, high = region.reach(0.5, {"zone": "lid"})
        box = weighted_box(region, 0.5, "lid")
        assert np.prod(high - low) < 1.6 * np.prod(box[1] - box[0])
