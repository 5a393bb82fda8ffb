"""Follows the landmarks of one face into the next frame: by its nets, or by its measured motion."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from makeup_video.pipeline.faces.crop_layout import CropLayout, lip_patch_to_px
from makeup_video.pipeline.faces.face import LipPatch
from makeup_video.pipeline.faces.landmarks import (
    AGREE_STILL,
    STILL_A_FACE,
    FaceLandmarks,
    disagreement,
    inside,
    is_plausible,
)
from makeup_video.pipeline.faces.nets import FaceNets, Mesh, Parts
from makeup_video.pipeline.faces.optical_flow import Motion
from makeup_video.pipeline.faces.similarity import STAY, Similarity, distance, iod_of
from makeup_video.pipeline.frames.clock import is_new_slot
from makeup_video.pipeline.frames.views import Picture

# How far a face moves between two frames: IOD, log scale or radians, whichever is largest.
_MOVED_FAR = 0.12  # from its expected pose; above this, the mesh net reads the face once more
_AT_REST = 0.015  # below this, the motion is mere noise
_JERK = 0.05  # more than a resting face moves in its first frame of motion
_FAST = 0.08  # above this, the mesh net reads every frame
# The mesh net runs once in a slot of this length. With longer slots the smoothed lips of a still
# face would shake.
_MESH_SECONDS = 0.1
# IOD between lips or eyes as the mesh net and as their own net reads them. If they are further
# apart, the crop of the lip or eye net lies in the wrong place.
_STRAYED = 0.2
# Shares of the way from the middle of the lip crop to its border. Lips that reach further than the
# first share are read again, if in a new crop they reach less far by at least the second.
_NEAR_BORDER, _CLEARLY_LESS = 0.97, 0.05
_LIPS_JUMP = 0.05  # IOD in one frame, relative to the eyes
_SHRUNK = 0.3  # log scale in _MESH_SECONDS: no face changes its size this fast
_CORRECTION = 0.3  # share of the way to the newly fitted pose; all of it would jolt the crops
# How much a new reading counts in the steady centres: the least share, and the distance in IOD from
# which on the reading alone counts.
_STEADY_SHARE, _STEADY_IOD = 0.1, 0.02


class _Read(NamedTuple):
    """What the lip and eye nets read, where their crops lay, and the widening the lips need."""

    layout: CropLayout
    parts: Parts
    widening: float


def relocate(
    nets: FaceNets,
    picture: Picture,
    before: FaceLandmarks,
    seconds: float,
    verify: bool = False,
) -> FaceLandmarks | None:
    """The same face a frame later, at `seconds` of the video; None when the face is gone.

    The lip and eye nets read every frame, at the place that the face's motion leads to. The mesh
    net runs now and then: it reads the other points, and checks that this still is a face. In
    between, the other points move along with the eyes. verify: check the mirrored crop, too.
    """
    is_due = is_new_slot(seconds, before.meshed_seconds, _MESH_SECONDS)
    if not (verify or before.moved > _FAST or is_due):
        found = _moved_along(nets, picture, before)
        if not _is_odd(before, found):
            return found
    return _read_again(nets, picture, before, seconds, verify)


def carry(nets: FaceNets, before: FaceLandmarks, motion: Motion) -> FaceLandmarks | None:
    """The same face a frame later, moved by its measured motion.

    None when the nets must read the face instead.
    """
    part_xy = motion.move(before.xy[nets.part_points])
    centres = nets.part_centres(part_xy)
    step = _step_between(before.centres, centres)
    pose = step.after(before.pose)
    moved = distance(before.pose, pose)
    if moved > _FAST:
        return None
    xy = step.apply(before.xy)
    xy[nets.part_points] = part_xy
    steady = _steady(before, centres)
    layout = nets.layout_around(steady, before.steady_widening).rounded(before.layout)
    to_px = lip_patch_to_px(layout)
    logits = motion.move_patch(before.lips.logits, before.lips.to_px, to_px)
    found = FaceLandmarks(
        xy, before.z, before.scores, pose, LipPatch(logits, to_px, layout.lip_span), layout,
        centres, steady, before.steady_widening, before.meshed_seconds, step, moved,
    )  # fmt: skip
    return None if _is_odd(before, found) else found


def expected_pose(before: FaceLandmarks) -> Similarity:
    """The pose in the next frame, if the face keeps moving as it does."""
    return _going_on(before).after(before.pose)


def _going_on(before: FaceLandmarks) -> Similarity:
    """The motion to the next frame, if the face keeps moving as it does; none at rest."""
    return STAY.towards(before.step, min(max(before.moved / _AT_REST - 0.5, 0), 1))


def _moved_along(nets: FaceNets, picture: Picture, before: FaceLandmarks) -> FaceLandmarks:
    """The face a frame later: lips and eyes are read, the other points move along with the eyes."""
    read = _read_parts(nets, picture, _expected_layout(nets, before))
    step = _step_between(before.centres, read.parts.centres)
    xy = step.apply(before.xy)
    xy[nets.part_points] = read.parts.xy
    return _next(before, xy, step.after(before.pose), step, read)


def _read_again(
    nets: FaceNets, picture: Picture, before: FaceLandmarks, seconds: float, verify: bool
) -> FaceLandmarks | None:
    """The face a frame later, with all points read; None when the face is gone."""
    layout = _expected_layout(nets, before)
    checked = _mesh_again(nets, picture, layout.pose, verify)
    if checked is None:
        return None
    mesh, is_where_expected = checked
    xy, z = _going_on(before).apply(before.xy), before.z.copy()
    strayed_px = _STRAYED * iod_of(layout.pose) if is_where_expected else 0
    if nets.merge_mesh(xy, z, mesh, strayed_px):
        layout = nets.crop_layout(xy).rounded()
    read = _read_parts(nets, picture, layout)
    step = _step_between(before.centres, read.parts.centres)
    xy[nets.part_points] = read.parts.xy
    pose = step.after(before.pose).towards(nets.fit_pose(xy), _CORRECTION)
    found = _next(before, xy, pose, step, read)
    found.z, found.scores, found.meshed_seconds = z, mesh.scores, seconds
    return found


def _next(
    before: FaceLandmarks, xy: np.ndarray, pose: Similarity, step: Similarity, read: _Read
) -> FaceLandmarks:
    """The landmarks a frame later; what only the mesh net reads stays as before."""
    layout, parts, widening = read
    return FaceLandmarks(
        xy, before.z, before.scores, pose, parts.lips, layout, parts.centres,
        _steady(before, parts.centres), _steady_number(before.steady_widening, widening),
        before.meshed_seconds, step, distance(before.pose, pose),
    )  # fmt: skip


def _read_parts(nets: FaceNets, picture: Picture, layout: CropLayout) -> _Read:
    """Read lips and eyes in the expected crops.

    Lips that suddenly moved or opened beyond their crop are read again in a crop around them.
    """
    parts = nets.read_parts(picture, layout)
    widening = nets.widening(parts.xy, layout.pose)
    reach = nets.lips_reach(parts.xy, layout)
    if reach > _NEAR_BORDER:
        better = nets.layout_that_holds(parts, widening, _NEAR_BORDER)
        if nets.lips_reach(parts.xy, better) < reach - _CLEARLY_LESS:
            layout, parts = better, nets.read_parts(picture, better)
            widening = nets.widening(parts.xy, layout.pose)
    return _Read(layout, parts, widening)


def _step_between(before: Sequence[complex], now: Sequence[complex]) -> Similarity:
    """The similarity that maps both eyes' rims before to the rims now; both: `part_centres`."""
    left, right, new_left, new_right = (*before[3:], *now[3:])
    across = right - left
    turn = (new_right - new_left) / across if across else 1 + 0j
    return Similarity(turn, new_left - turn * left)


def _steady(before: FaceLandmarks, centres: Sequence[complex]) -> list[complex]:
    """The steady centres with one more reading: noise fades, and motion is followed.

    A layout around single readings would swing between two grid points that are about equally near.
    """
    far = _STEADY_IOD * iod_of(before.pose)
    steady = []
    for mean, new in zip(before.steady_centres, centres, strict=True):
        off = new - mean
        steady.append(mean + min(max(abs(off) / far, _STEADY_SHARE), 1) * off)
    return steady


def _steady_number(mean: float, new: float) -> float:
    """The same for the widening of the lip crop; a change by a whole step counts at once."""
    return mean + max(_STEADY_SHARE, min(abs(new - mean), 1)) * (new - mean)


def _is_odd(before: FaceLandmarks, found: FaceLandmarks) -> bool:
    """Whether the lips jumped or vanished, or a resting face suddenly moved.

    Something may be in front of the lips. Or the video skipped a frame, and lips and eyes were read
    in the wrong place.
    """
    jump = abs(found.centres[0] - found.step.apply(before.centres[0]))
    if jump > _LIPS_JUMP * iod_of(found.pose) or found.painted_px < before.painted_px / 2:
        return True
    return before.moved < _AT_REST and found.moved > _JERK


def _expected_layout(nets: FaceNets, before: FaceLandmarks) -> CropLayout:
    """Where the crops of a face lie in the next frame, if the face keeps moving as it does."""
    step = _going_on(before)
    centres = [step.apply(centre) for centre in before.steady_centres]
    return nets.layout_around(centres, before.steady_widening).rounded(before.layout)


def _mesh_again(
    nets: FaceNets, picture: Picture, expected: Similarity, verify: bool
) -> tuple[Mesh, bool] | None:
    """The mesh, and whether the face is where it was expected; None when there is no face."""
    mesh = nets.read_mesh(picture, expected)
    pose = nets.fit_pose(mesh.xy)
    is_where_expected = distance(expected, pose) < _MOVED_FAR
    if not is_where_expected:
        mesh = nets.read_mesh(picture, pose)
        pose = nets.fit_pose(mesh.xy)
    resized = abs(math.log(max(iod_of(pose), 1e-6) / iod_of(expected)))
    if mesh.scores[0] < STILL_A_FACE or resized > _SHRUNK or not is_plausible(mesh.xy, picture):
        return None
    if verify:
        mirrored = nets.read_mesh(picture, pose, mirrored=True)
        if disagreement(mesh, mirrored, pose, inside(mesh.xy, picture)) > AGREE_STILL:
            return None
    return mesh, is_where_expected
