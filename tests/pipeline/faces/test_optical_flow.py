"""Known motion is measured; cuts, hands and jumps give no motion."""

import cv2
import numpy as np
import pytest
from makeup_video.pipeline.faces.optical_flow import MeasureMotion
from makeup_video.pipeline.faces.similarity import Similarity, iod_of
from makeup_video.pipeline.faces.topology import LIPS
from makeup_video.pipeline.frames.affine import compose
from makeup_video.pipeline.frames.views import FramePicture
from people import clip, clip_points, frame_of, portrait

POSE = Similarity(119.3 - 4.2j, 262.6 + 190.6j)  # the pose of the portrait's face


def crop_of(measure, rgb8, pose=POSE, **how):
    return measure.crop(FramePicture(frame_of(rgb8, **how)), pose)


def moved_picture(matrix):
    rgb8 = portrait()
    return cv2.warpAffine(rgb8, matrix, rgb8.shape[1::-1], borderMode=cv2.BORDER_REPLICATE)


def matrix(shift=(0.0, 0.0), scale=1.0, degrees=0.0):
    to = cv2.getRotationMatrix2D((256, 250), degrees, scale)
    to[:, 2] += shift
    return to


def places():
    y, x = np.mgrid[200:300:5, 210:300:5]
    return (x + 1j * y).ravel()


def apply(to, xy):
    real, imag = to[:, :2] @ np.stack([xy.real, xy.imag]) + to[:, 2:]
    return real + 1j * imag


MOVES = [
    matrix(),
    matrix(shift=(2.3, -1.6)),
    matrix(shift=(-5.0, 3.0)),
    matrix(scale=1.03),
    matrix(degrees=2.0),
    matrix((1.0, 1.0), 0.98, -1.5),
]


@pytest.mark.parametrize("to", MOVES)
@pytest.mark.parametrize("rotation", [0, 90])
def test_a_known_motion_is_measured(to, rotation):
    measure = MeasureMotion()
    before, now = (
        crop_of(measure, rgb8, rotation_degrees=rotation)
        for rgb8 in (portrait(), moved_picture(to))
    )
    motion = measure(before, now)
    assert motion is not None
    off = np.abs(motion.move(places()) - apply(to, places()))
    assert off.mean() < 0.006 * iod_of(POSE)


def test_where_the_second_crop_lies_does_not_matter():
    """The tracker places the crop where it expects the face."""
    measure, to = MeasureMotion(), matrix(shift=(9.0, 4.0))
    expected = Similarity(POSE.turn * 1.01, POSE.shift + (8 + 5j))
    motion = measure(crop_of(measure, portrait()), crop_of(measure, moved_picture(to), expected))
    assert motion is not None
    off = np.abs(motion.move(places()) - apply(to, places()))
    assert off.mean() < 0.006 * iod_of(POSE)


@pytest.mark.parametrize("pix_fmt", ["yuv420p10le", "nv12", "yuv444p", "gray"])
def test_every_layout_gives_the_same_motion(pix_fmt):
    measure, to = MeasureMotion(), matrix(shift=(2.3, -1.6))
    crops = [crop_of(measure, p, pix_fmt=pix_fmt) for p in (portrait(), moved_picture(to))]
    assert crops[0].luma8.dtype == np.uint8
    motion = measure(*crops)
    assert motion is not None
    assert np.abs(motion.move(places()) - apply(to, places())).mean() < 0.006 * iod_of(POSE)


def test_a_new_scene_a_hand_or_a_jump_gives_no_motion():
    measure = MeasureMotion()
    before = crop_of(measure, portrait())
    hand = portrait().copy()
    hand[270:330, 200:310] = (205, 160, 130)
    for other in (portrait()[::-1], np.roll(portrait(), 60, 1), hand):
        assert measure(before, crop_of(measure, np.ascontiguousarray(other))) is None


def test_a_patch_moves_with_what_it_lay_on():
    measure, to = MeasureMotion(), matrix((3.0, 1.0), 1.01, 1.0)
    motion = measure(crop_of(measure, portrait()), crop_of(measure, moved_picture(to)))
    assert motion is not None
    y, x = np.mgrid[0:80, 0:112].astype(np.float32)
    patch = 0.01 * (x - 50) ** 2 - 0.02 * (y - 40) ** 2
    to_px = np.array([[1.0, 0, 200], [0, 1.0, 240]])
    turned = matrix(degrees=3.0)  # the new patch may be turned
    now_px = compose(turned, to_px)
    carried = motion.move_patch(patch, to_px, now_px)
    way = compose(cv2.invertAffineTransform(compose(to, to_px)), now_px)
    size = (112, 80)
    want = cv2.warpAffine(patch, way, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    inner = np.s_[12:-12, 12:-12]
    assert np.abs(carried - want)[inner].mean() < 0.02 * np.ptp(want[inner])


def test_speaking_lips_are_followed_better_than_held_ones():
    measure, pictures, points = MeasureMotion(), clip(30), clip_points(30)
    moved, still = [], []
    for index in range(29):
        left, right = (complex(*points[index, point]) for point in (33, 263))
        pose = Similarity(right - left, (left + right) / 2)
        motion = measure(
            crop_of(measure, pictures[index], pose), crop_of(measure, pictures[index + 1], pose)
        )
        lips, now = (points[i, LIPS, 0] + 1j * points[i, LIPS, 1] for i in (index, index + 1))
        if motion is not None:
            moved.append(np.abs(motion.move(lips) - now).mean())
            still.append(np.abs(lips - now).mean())
    assert len(moved) > 20
    assert np.mean(moved) < 0.6 * np.mean(still)


@pytest.mark.parametrize(("px", "is_measured"), [(1.0, True), (9.0, False)])
def test_a_mouth_that_opens_fast_is_left_to_the_nets(px, is_measured):
    """The lower lip drops by `px` in one frame, and the upper lip stays."""
    rgb8, y = portrait(), np.mgrid[0:600, 0:512][0].astype(np.float32)
    x = np.mgrid[0:600, 0:512][1].astype(np.float32)
    lower = np.exp(-((x - 267) ** 2 / 2 / 30**2 + (y - 292) ** 2 / 2 / 14**2)).astype(np.float32)
    opened = cv2.remap(rgb8, x, y - px * lower, cv2.INTER_LINEAR)
    measure = MeasureMotion()
    motion = measure(crop_of(measure, rgb8), crop_of(measure, opened))
    assert (motion is not None) == is_measured
