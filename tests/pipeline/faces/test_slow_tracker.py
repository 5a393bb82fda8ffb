"""Faces on a slow machine: detection runs less often, and the nets read every second frame."""

import numpy as np
import pytest
from makeup_video.pipeline import FindFaces
from makeup_video.pipeline.faces import tracker
from makeup_video.pipeline.faces.nets import FaceNets
from makeup_video.pipeline.faces.topology import EYE_CORNERS
from people import clip, clip_points, face_of, frame_of, grey, put


class CountedNets(FaceNets):
    """Counts the runs of the nets."""

    def __init__(self):
        super().__init__()
        self.detections = self.parts = self.meshes = 0

    def detect(self, *rest, **how):
        self.detections += 1
        return super().detect(*rest, **how)

    def read_parts(self, *rest, **how):
        self.parts += 1
        return super().read_parts(*rest, **how)

    def read_mesh(self, *rest, **how):
        self.meshes += 1
        return super().read_mesh(*rest, **how)


def run(pictures, level):
    find = FindFaces(nets=CountedNets())
    find.level = level
    return [find(frame_of(picture, index)) for index, picture in enumerate(pictures)], find


def errors_percent(found):
    """(N,) mean error of all points per frame, in percent of the distance between the eyes."""
    errors = []
    for item, true in zip(found, clip_points(len(found)), strict=True):
        unit = np.linalg.norm(np.subtract(*true[list(EYE_CORNERS)]))
        off = item.faces[0].points_px[:, :2] - true
        errors.append(100 * np.linalg.norm(off, axis=1).mean() / unit)
    return np.array(errors)


def test_from_level_1_new_faces_are_searched_once_a_second():
    pictures = [clip()[0]] * 62
    _, often = run(pictures, 0)
    _, seldom = run(pictures, 1)
    assert often.nets.detections >= 8
    assert seldom.nets.detections <= 3


def test_from_level_2_the_nets_read_every_second_frame():
    pictures = clip()
    whole, often = run(pictures, 0)
    found, seldom = run(pictures, 2)
    assert seldom.nets.parts < 0.65 * often.nets.parts
    assert seldom.nets.meshes < often.nets.meshes
    assert all(len(item.faces) == 1 and item.faces[0].track_id == 0 for item in found)
    assert errors_percent(found).mean() < 1.1 * errors_percent(whole).mean()
    assert errors_percent(found).max() < 1.3 * errors_percent(whole).max()


def test_with_two_faces_the_nets_read_one_per_frame():
    """This way, no frame takes twice as long as the next."""
    ground = grey(640, 360)
    for x in (0, 320):
        ground = put(ground, face_of(120), x, 40)
    find = FindFaces(nets=CountedNets())
    find.level = 2
    read = []
    for index in range(20):
        before = find.nets.parts
        assert len(find(frame_of(ground, index)).faces) == 2
        read.append(find.nets.parts - before)
    assert read[5:].count(1) >= 12 and max(read[5:]) <= 2


def test_a_face_that_motion_loses_is_read_by_the_nets():
    """The same face jumps to another place."""
    small = face_of(110)
    pictures = [put(grey(640, 360), small, 200 + 90 * (index >= 6), 50) for index in range(14)]
    found, _ = run(pictures, 2)
    want, _ = run(pictures, 0)
    for a, b in zip(found[9:], want[9:], strict=True):
        off = a.faces[0].points_px[:, :2] - b.faces[0].points_px[:, :2]
        assert np.abs(off).mean() < 1.5


def test_a_face_that_left_is_lost_at_the_nets_next_run():
    pictures = [put(grey(640, 360), face_of(110), 200, 50)] * 6 + [grey(640, 360)] * 4
    found, _ = run(pictures, 2)
    assert all(item.faces for item in found[:6])
    assert not any(item.faces for item in found[7:])


@pytest.mark.parametrize("levels", [(0, 1, 2, 3, 2, 1, 0), (3, 0, 3, 0)])
def test_the_level_may_change_between_any_two_frames(levels):
    find = FindFaces()
    found = []
    for index, picture in enumerate(clip(35)):
        find.level = levels[index // 5 % len(levels)]
        found.append(find(frame_of(picture, index)))
    assert {item.faces[0].track_id for item in found} == {0}
    assert errors_percent(found).max() < 6


def test_search_intervals_are_in_order():
    assert tracker.SEARCH_SECONDS < tracker.SLOW_SEARCH_SECONDS < tracker.SLOW_DETECT_SECONDS
    assert tracker.SEARCH_SECONDS < tracker.DETECT_SECONDS < tracker.SLOW_DETECT_SECONDS
