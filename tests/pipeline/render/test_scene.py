"""Scene lights check the shapes of their arrays."""

import numpy as np
import pytest
from makeup import white_light
from makeup_video.pipeline.render.scene import SceneLight


def test_white_light_is_white_and_from_the_viewers_side():
    light = white_light()
    assert (light.colour == 1).all() and light.strength == 1
    assert np.linalg.norm(light.direction) == pytest.approx(1)
    assert light.direction[2] < 0 and light.direction[1] < 0  # from the front and above


@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_a_light_of_other_shapes_is_refused(wrong):
    parts = [np.ones(3), np.array([0, 0, -1.0]), np.zeros((16, 16, 3))]
    parts[wrong] = np.ones((4, 4))
    with pytest.raises(ValueError, match=r"\(16, 16, 3\)"):
        SceneLight(parts[0], 1.0, parts[1], parts[2])
