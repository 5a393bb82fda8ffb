"""The window that is painted holds every pixel with weight, and little else."""

import numpy as np
import pytest
from heads import HEAD_PX, face
from layers import SLOTS, densities, lipstick, shadow
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces
from makeup_video.pipeline.render.surfaces.lips_twin import lips_surface
from makeup_video.pipeline.render.surfaces.surface import Edge


def weighted_box(side, edge, density):
    """Return the lowest and the highest (x, y) with weight in a large picture, or None."""
    weight = np.zeros((720, 1280), np.float32)
    side.weigh(weight, (0, 0), edge, density)
    y, x = np.nonzero(weight)
    return (np.array([x.min(), y.min()]), np.array([x.max(), y.max()])) if len(x) else None


@pytest.mark.parametrize("softness", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("slot", SLOTS)
def test_no_weight_lies_beyond_the_reach(softness, slot):
    seen = 0
    for index in range(0, len(HEAD_PX), 60):
        head = face(HEAD_PX[index])
        worn = [(lips_surface(head), lipstick(softness))]
        worn += [(lid, shadow(slot, softness)) for lid in lid_surfaces(head)]
        for surface, layer in worn:
            for side, density in densities(surface, layer):
                for edge in (Edge(softness), Edge(softness, 1.0)):
                    low, high = np.array(side.reach(edge, density))
                    box = weighted_box(side, edge, density)
                    if box is not None:
                        assert (box[0] >= np.floor(low)).all() and (box[1] <= np.ceil(high)).all()
                        seen += 1
    assert seen >= 6 * len(range(0, len(HEAD_PX), 60))


def test_the_reach_of_a_lid_is_no_more_than_its_zone_needs():
    for surface in lid_surfaces(face(HEAD_PX[0])):
        above, density = densities(surface, shadow("lid"))[0]
        low, high = np.array(above.reach(Edge(0.5), density))
        box = weighted_box(above, Edge(0.5), density)
        assert np.prod(high - low) < 1.6 * np.prod(box[1] - box[0])
