"""An upside-down face that was read as an upright one is turned the right way up."""

from dataclasses import replace

import numpy as np
import pytest
from makeup_video.pipeline.faces import right_way_up as module
from makeup_video.pipeline.faces.landmarks import detect, locate
from makeup_video.pipeline.faces.nets import load_nets
from makeup_video.pipeline.faces.right_way_up import right_way_up
from makeup_video.pipeline.faces.similarity import Similarity, distance
from makeup_video.pipeline.frames.views import RgbPicture
from people import portrait, veiled


def face_on_its_head(upright):
    """(nets, the picture turned upside down, its face as a correct reading gives it)."""
    nets, picture = load_nets(), RgbPicture(np.ascontiguousarray(upright[::-1, ::-1]))
    (detection,) = detect(nets, picture, (256,), 180)[:1]
    return nets, picture, locate(nets, picture, detection, average=True)


@pytest.fixture(scope="module")
def on_its_head():
    return face_on_its_head(portrait()[60:500, 40:480])


def as_if_upright(face, scores):
    """The face as a wrong reading gives it: with its pose turned by 180 degrees."""
    return replace(face, pose=Similarity(-face.pose.turn, face.pose.shift), scores=scores)


# scores from photos: mostly the mouth seems hidden, sometimes a brow is taken for a mouth
@pytest.mark.parametrize("scores", [(0.9, 0.05), (0.97, 0.94), (0.989, 0.011)])
def test_a_face_on_its_head_that_seems_upright_is_turned(on_its_head, scores):
    nets, picture, face = on_its_head
    found = right_way_up(nets, picture, as_if_upright(face, scores), average=True)
    assert found.scores[1] > 0.5 and distance(found.pose, face.pose) < 0.05


def test_the_right_way_up_nothing_is_turned(on_its_head):
    nets, picture, face = on_its_head
    assert right_way_up(nets, picture, face) is face
    doubtful = replace(face, scores=(0.9, 0.1))  # read the other way up, it is no face at all
    assert right_way_up(nets, picture, doubtful) is doubtful


def test_only_the_same_face_counts_if_it_is_surer(on_its_head):
    nets, picture, face = on_its_head
    wrong = as_if_upright(face, (0.9, 0.05))
    far = replace(wrong, xy=wrong.xy + 1000)
    assert right_way_up(nets, picture, far) is far
    as_sure = replace(wrong, scores=(face.scores[0], 0.19))
    assert right_way_up(nets, picture, as_sure) is not as_sure
    surer = replace(wrong, scores=(1 - (1 - face.scores[0]) / 9, 0.19))
    assert right_way_up(nets, picture, surer) is surer


def test_a_surer_reading_the_same_way_up_is_no_reason(on_its_head, monkeypatch):
    nets, picture, face = on_its_head
    doubtful = replace(face, scores=(0.9, 0.05))
    monkeypatch.setattr(module, "locate", lambda *_: face)
    assert right_way_up(nets, picture, doubtful) is doubtful


def test_scores_of_nothing_and_of_certainty_are_compared(on_its_head):
    nets, picture, face = on_its_head
    wrong = as_if_upright(face, (0.0, 0.0))
    assert right_way_up(nets, picture, wrong) is not wrong
    certain = as_if_upright(face, (1.0, 0.0))
    assert right_way_up(nets, picture, certain) is certain


def test_a_mask_does_not_hide_which_way_is_up():
    """The mouth is hidden either way up, so the face's own score decides."""
    nets, picture, face = face_on_its_head(veiled(portrait()[60:500, 40:480]))
    assert face.scores[1] < 0.2
    found = right_way_up(nets, picture, as_if_upright(face, (0.93, 0.1)), average=True)
    assert found.scores[1] < 0.2 and distance(found.pose, face.pose) < 0.05
    assert right_way_up(nets, picture, face) is face
