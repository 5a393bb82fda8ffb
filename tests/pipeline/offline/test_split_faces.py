"""Faces across the seams of a video in segments: their numbers, and how they are painted."""

from collections import Counter
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from makeup_video.pipeline import Settings, find_faces, process_video, ready_look
from makeup_video.pipeline.offline.split import plan_of
from media import decoded
from people import clip, face_of, grey, put, veiled, write_video
from workers import InThisProcess

LOOK = ready_look("glam").look
MINUTES = Fraction(5, 2 * 60)
# The run-up of the second segment takes two seconds, and begins well after the video does.
FRAMES, SEAM = 120, 75
SECOND_FACE = range(50, 110)


@pytest.fixture(scope="module")
def two_faces(tmp_path_factory):
    """A face that moves a little, and a smaller one that comes later and leaves before the end."""
    path = tmp_path_factory.mktemp("video") / "in.mkv"
    pictures = []
    for index in range(FRAMES):
        shift = round(12 * np.sin(index / 9))
        pictures.append(put(grey(), face_of(150), 60 + shift, 20))
        if index in SECOND_FACE:
            pictures[-1] = put(pictures[-1], face_of(100), 410, 90 + shift // 2)
    return write_video(path, pictures, options={"g": "15"})


def paint(src, folder, workers=None, **settings):
    """(the video of one run, the video in segments, both reports), without loss."""
    whole, split = folder / "whole.mkv", folder / "split.mkv"
    one = process_video(src, whole, LOOK, Settings(codec="ffv1", **settings))
    in_segments = Settings(codec="ffv1", split_minutes=MINUTES, **settings)
    many = process_video(src, split, LOOK, in_segments, workers=workers)
    return whole, split, one, many


@pytest.fixture(scope="module")
def painted(two_faces, tmp_path_factory):
    """`paint` for the video of two faces: once for each choice of faces."""

    @cache
    def painted(faces):
        # Processes for one choice: their start takes as long as painting a video of that length.
        workers = None if faces == "largest" else [InThisProcess()]
        return paint(two_faces, tmp_path_factory.mktemp("painted"), workers, faces=faces)

    return painted


def face_psnr(one, other, face):
    """PSNR of the luma in the box around a face, dB."""
    (x0, y0), (x1, y1) = (f(face.points_px[:, :2], axis=0).astype(int) for f in (np.min, np.max))
    boxes = [p.to_ndarray()[max(y0, 0) : y1, max(x0, 0) : x1].astype(float) for p in (one, other)]
    error = np.square(boxes[0] - boxes[1]).mean()
    return 10 * np.log10(255**2 / max(error, 1e-9))


@pytest.mark.parametrize("whom", ["all", "largest", "1"])
def test_faces_are_painted_alike_on_both_sides_of_a_seam(two_faces, painted, whom):
    *videos, one, many = painted(whom)
    whole, split = map(decoded, videos)
    assert many.segments == 2 and len(whole) == len(split) == FRAMES
    for name in ("faces", "frames_with_face", "painted_frames", "warnings"):
        first, second = getattr(one, name), getattr(many, name)
        assert (first() if name == "warnings" else first) == (
            second() if name == "warnings" else second
        )
    plan, bare = plan_of(two_faces, LOOK, MINUTES, Settings()), decoded(two_faces)
    assert [round(one.first / Fraction(1000, 30)) for one in plan.segments] == [0, SEAM]
    for number in range(SEAM - 5, SEAM + 30, 5):
        faces = find_faces(whole[number].to_ndarray(format="rgb24"))
        assert faces
        assert min(face_psnr(whole[number], split[number], face) for face in faces) > 45
        # A face that is left out is far below that.
        assert min(face_psnr(whole[number], bare[number], face) for face in faces) < 32


def test_only_the_chosen_face_of_a_later_segment_is_painted(two_faces, painted):
    """Face 1 appears in the first segment; the second takes its number from there."""
    _, split, _, many = painted("1")
    assert many.painted_frames > 0.8 * len(SECOND_FACE)
    changed = [
        np.abs(old.to_ndarray()[:360].astype(int) - new.to_ndarray()[:360]).max(axis=0)
        for old, new in zip(decoded(two_faces), decoded(split), strict=True)
    ]
    assert all(columns[:380].max() == 0 for columns in changed)  # face 0 is not painted
    assert all(columns.max() > 20 for columns in changed[SEAM + 10 : 105])


def test_a_face_that_was_chosen_and_never_came_is_named_once(painted):
    *_, one, many = painted("7")
    assert many.painted_frames == 0 and many.why_unpainted == one.why_unpainted
    assert "the faces seen were 0 and 1" in many.why_unpainted


def test_a_part_that_one_segment_shows_is_not_missed(tmp_path):
    seen = put(grey(), face_of(200), 200, 20)
    pictures = [veiled(seen)] * (SEAM + 15) + [seen] * (FRAMES - SEAM - 15)
    src = write_video(tmp_path / "in.mkv", pictures, options={"g": "15"})
    *_, one, many = paint(src, tmp_path, [InThisProcess()])
    assert many.segments == 2 and one.warnings() == many.warnings() == []


def test_a_part_that_no_segment_shows_is_missed_in_all(tmp_path):
    pictures = [veiled(put(grey(), face_of(200), 200, 20))] * FRAMES
    src = write_video(tmp_path / "in.mkv", pictures, options={"g": "15"})
    *_, one, many = paint(src, tmp_path, [InThisProcess()])
    assert many.segments == 2 and one.warnings() == many.warnings() != []


class Noting(InThisProcess):
    """Notes how often each segment is painted."""

    def __init__(self):
        self.jobs = []

    def run(self, task, job, report):
        self.jobs.append(job.path.name)
        return super().run(task, job, report)


@pytest.mark.parametrize(("whom", "painted_frames"), [("0", range(10)), ("1", range(40, FRAMES))])
def test_a_segment_that_mixed_up_faces_is_painted_again(tmp_path, whom, painted_frames):
    """Face 0 has left before the run-up of the second segment, which begins with face 1 as its own
    face 0."""
    left, right = put(grey(), face_of(150), 20, 20), put(grey(), face_of(150), 330, 20)
    pictures = [left if index < 10 else right if index >= 40 else grey() for index in range(FRAMES)]
    changed = changed_twice(tmp_path, pictures, whom)
    for number, frames in enumerate(zip(*changed, strict=True)):
        assert all(columns.any() == (number in painted_frames) for columns in frames)


def test_a_segment_that_took_a_larger_face_is_painted_again(tmp_path):
    """The makeup stays on a face when a slightly larger one comes, and the second segment sees both
    from its beginning."""
    right = put(grey(), face_of(138), 340, 20)
    both = put(right, face_of(150), 10, 20)
    pictures = [right if index < 8 else both for index in range(FRAMES)]
    for columns in zip(*changed_twice(tmp_path, pictures, "largest"), strict=True):
        assert all(one[340:].any() and not one[:320].any() for one in columns)


def changed_twice(folder, pictures, whom):
    """For one run and for one in segments: by frame, the painted columns, (640,) bool.

    One segment must be painted twice.
    """
    src, worker = write_video(folder / "in.mkv", pictures, options={"g": "15"}), Noting()
    *videos, one, many = paint(src, folder, [worker], faces=whom)
    assert many.segments == 2 and sorted(Counter(worker.jobs).values()) == [1, 2]
    assert many.painted_frames == one.painted_frames
    bare = [frame.to_ndarray()[:360] for frame in decoded(src)]
    return [
        [
            (frame.to_ndarray()[:360] != old).any(axis=0)
            for frame, old in zip(decoded(video), bare, strict=True)
        ]
        for video in videos
    ]


def test_a_video_of_the_sample_is_alike_at_its_seam(tmp_path):
    """A rendered head that talks and turns; the tracker's state is never quite the same."""
    src = write_video(tmp_path / "in.mkv", clip(FRAMES), options={"g": "5"})
    *videos, one, many = paint(src, tmp_path, [InThisProcess()])
    whole, split = map(decoded, videos)
    assert many.segments == 2 and (one.faces, one.painted_frames) == (many.faces, FRAMES)
    for number in range(SEAM, SEAM + 30, 3):
        (face,) = find_faces(whole[number].to_ndarray(format="rgb24"))
        assert face_psnr(whole[number], split[number], face) > 45
