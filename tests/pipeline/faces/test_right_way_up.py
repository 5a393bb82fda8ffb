"""A face that stands on its head and passes for an upright one is turned the right way up."""

from dataclasses import replace

import numpy as np
from makeup_video.pipeline.faces.landmarks import detect, locate
from makeup_video.pipeline.faces.nets import load_nets
from makeup_video.pipeline.faces.right_way_up import UpsideDown
from makeup_video.pipeline.faces.similarity import Similarity, distance
from makeup_video.pipeline.frames.views import RgbPicture
from people import portrait


def test_a_face_on_its_head_that_seems_upright_is_turned():
    """Half of all such faces pass for upright ones, with hidden mouths, about an IOD too high."""
    picture = np.ascontiguousarray(portrait()[60:500, 40:480][::-1, ::-1])
    nets, frame = load_nets(), RgbPicture(picture)
    (detection,) = detect(nets, frame, (256,), 180)[:1]
    face = locate(nets, frame, detection, average=True)
    right_way_up = UpsideDown(nets, frame, (256,), average=True).right_way_up
    upright = Similarity(-face.pose.turn, face.pose.shift)
    wrong = replace(face, pose=upright, scores=(0.9, 0.05))
    assert right_way_up(face) is face
    found = right_way_up(wrong)
    assert found.scores[1] > 0.5 and distance(found.pose, face.pose) < 0.05
    far = replace(wrong, xy=wrong.xy + 1000)
    assert right_way_up(far) is far
