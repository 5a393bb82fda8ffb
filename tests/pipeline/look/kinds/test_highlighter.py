"""Highlighter lies on the cheekbones, the ridge of the nose and cupid's bow, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import KINDS, product
from makeup_video.pipeline.look.kinds.fields import FaceFields

KIND = KINDS["highlighter"]
ALONG = np.linspace(-1, 1, 201, dtype=np.float32)
FIELDS = FaceFields(
    ALONG[None, None, :], np.linspace(-0.5, 1, 151, dtype=np.float32)[None, :, None]
)
OFF = {"cheekbone": 0, "nose": 0, "bow": 0}
# Places on the mean face: across and down, as shares of the distance of the outer eye corners.
PLACES = {"cheekbone": (0.62, 0.12), "nose": (0.0, 0.25), "bow": (0.0, 0.615)}


def density(**shape):
    worn = product((250, 226, 200), "shimmer", "highlighter")
    (coat,) = KIND.coats(FIELDS, worn, KIND.whole_shape(shape))
    assert coat.density.shape == (1, 151, 201) and coat.density.dtype == np.float32
    return coat.density[0]


@pytest.mark.parametrize("kind", ["highlighter", "blush"])
def test_a_softer_edge_fades_further(kind):
    drawn = []
    for softness in (0.0, 0.4, 0.8, 1.0):
        worn = replace(product((250, 226, 200), "matte", kind), edge_softness=softness)
        (coat,) = KINDS[kind].coats(FIELDS, worn, KINDS[kind].whole_shape({}))
        drawn.append((coat.density > 0.01).sum() - (coat.density > 0.99).sum())
    assert (np.diff(drawn) > 0).all()


def at(found, across, down):
    return found[np.abs(FIELDS.down[0, :, 0] - down).argmin(), np.abs(ALONG - across).argmin()]


@pytest.mark.parametrize("name", PLACES)
def test_each_dial_paints_its_own_place(name):
    found = density(**{**OFF, name: 1})
    for other, (across, down) in PLACES.items():
        assert at(found, across, down) == pytest.approx(1 if other == name else 0, abs=0.02)
    assert density(**{**OFF, name: 0.4}).max() == pytest.approx(0.4, abs=0.01)


def test_nothing_lies_on_the_eyes_and_the_cheeks_apples():
    found = density()
    assert at(found, 0.35, 0.0) == at(found, 0.4, 0.5) == 0


@given(st.fixed_dictionaries({d.name: st.floats(d.low, d.high) for d in KIND.dials}))
def test_both_sides_of_the_face_are_alike_for_every_shape(shape):
    found = density(**shape)
    assert found.min() >= 0 and found.max() <= 1
    np.testing.assert_allclose(found, found[:, ::-1], atol=1e-3)
