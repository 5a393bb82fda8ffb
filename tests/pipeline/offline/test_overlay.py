"""The overlay shows the found faces in every layout and leaves other frames unchanged."""

import json
from dataclasses import replace

import numpy as np
import pytest
from makeup_video.pipeline import FrameFaces, OutputError, StoppedError, UsageError
from makeup_video.pipeline.faces.find import find_faces_in_frame
from makeup_video.pipeline.offline.overlay import DrawFaces, _draw_label
from makeup_video.pipeline.offline.points_file import PointsFile
from people import frame_of, grey, portrait


def found_in(frame) -> FrameFaces:
    return find_faces_in_frame(frame)[0]


def difference(frame, before) -> np.ndarray:
    luma = frame.planes[0]
    return luma.astype(int) != before.planes[0].astype(int)


@pytest.mark.parametrize(
    "pix_fmt", ["yuv420p", "yuv422p", "yuv444p", "nv12", "yuv420p10le", "gray"]
)
@pytest.mark.parametrize("rotation", [0, 90, 270])
def test_points_lips_and_label_are_drawn_in_every_layout(pix_fmt, rotation):
    options = {"pix_fmt": pix_fmt, "rotation_degrees": rotation}
    plain = frame_of(portrait(), **options)
    item = found_in(frame_of(portrait(), **options))
    drawn = DrawFaces()(item)
    assert drawn is item.frame
    changed = difference(drawn, plain)
    hidden = 0  # a point may lie on a pixel of exactly its own grey
    for x, y in item.faces[0].points_px[:, :2]:
        around = changed[max(round(y) - 1, 0) : round(y) + 2, max(round(x) - 1, 0) : round(x) + 2]
        hidden += not around.any()
    assert hidden <= (2 if pix_fmt == "gray" else 0)
    assert 0.005 < changed.mean() < 0.2
    assert drawn.planes[0].max() <= 255 << (plain.bit_depth - 8)


@pytest.mark.parametrize("turns", range(4))
def test_a_mirrored_picture_shows_the_same_label(turns):
    shown = portrait()
    stored = np.ascontiguousarray(np.rot90(shown[:, ::-1], -turns))
    plain = frame_of(shown, pix_fmt="yuv444p")
    frame = frame_of(stored, pix_fmt="yuv444p", rotation_degrees=90 * turns)
    frame.is_mirrored = True
    (face,) = found_in(plain).faces
    # where each pixel that the viewer sees is stored
    place = np.rot90(np.indices(stored.shape[:2]), turns, (1, 2))[:, :, ::-1]
    x, y = np.rint(face.points_px[:, :2]).astype(int).T
    points = np.column_stack([*place[::-1, y, x], face.points_px[:, 2]]).astype(np.float32)
    whole = [np.zeros(picture.shape[:2], np.uint8) for picture in (shown, stored)]
    _draw_label((whole[0],), plain, replace(face, points_px=np.rint(face.points_px)))
    _draw_label((whole[1],), frame, replace(face, points_px=points))
    assert whole[0].any() and (np.rot90(whole[1], turns)[:, ::-1] == whole[0]).all()


def test_a_frame_without_a_face_keeps_every_byte():
    frame = frame_of(grey())
    before = [plane.copy() for plane in frame.planes]
    DrawFaces()(FrameFaces(frame))
    assert all((a == b).all() for a, b in zip(before, frame.planes, strict=True))


@pytest.mark.parametrize("shift", [(-160, -260), (200, 0), (0, 300), (5000, 5000), (-5000, 0)])
def test_a_face_partly_or_wholly_outside_does_no_harm(shift):
    (face,) = found_in(frame_of(portrait())).faces
    points = face.points_px + np.array([*shift, 0], np.float32)
    to_px = face.lips.to_px + np.array([[0, 0, shift[0]], [0, 0, shift[1]]])
    moved = replace(face, points_px=points, lips=replace(face.lips, to_px=to_px))
    for pix_fmt in ("yuv420p", "nv12"):
        DrawFaces()(FrameFaces(frame_of(portrait(), pix_fmt=pix_fmt), (moved,)))


def moved_to(face, left, top):
    """Return the face moved so that its points begin at (left, top), in pixels."""
    x, y = np.array([left, top]) - face.points_px[:, :2].min(0)
    to_px = face.lips.to_px + np.array([[0, 0, x], [0, 0, y]])
    points = face.points_px + np.array([x, y, 0], np.float32)
    return replace(face, points_px=points, lips=replace(face.lips, to_px=to_px))


def stored(face, frame):
    """Return a face of the upright picture as it lies in the square frame, stored turned."""
    x, y, z = face.points_px.T
    for _ in range((360 - frame.rotation_degrees) // 90 % 4):
        x, y = y, frame.width_px - 1 - x  # a quarter counter-clockwise
    return replace(face, points_px=np.stack([x, y, z], axis=1))


def label_of(frame) -> tuple[int, int, int, int]:
    """Return (left, top, right, bottom) of the label in the upright picture.

    Only the label has luma 16: grey() has no such black.
    """
    luma = np.rot90(frame.planes[0], frame.rotation_degrees // 90)
    rows, columns = np.nonzero(luma == 16)
    return columns.min(), rows.min(), columns.max(), rows.max()


@pytest.mark.parametrize("rotation", [0, 90, 180, 270])
def test_the_label_is_above_the_face_in_the_picture(rotation):
    width = height = 480  # square, so that `stored` is one formula for all rotations
    (face,) = found_in(frame_of(portrait())).faces
    size = np.ptp(face.points_px[:, :2], axis=0)
    places = {
        (140, 150): None, (-80, 150): None, (width - size[0] / 3, 150): None, (140, -60): None,
        (140, height - 60): None,
    }  # fmt: skip
    for left, top in places:
        frame = frame_of(grey(width, height), rotation_degrees=rotation)
        DrawFaces()(FrameFaces(frame, (stored(moved_to(face, left, top), frame),)))
        places[left, top] = label_of(frame)
    middle = places[140, 150]
    wide, high = middle[2] - middle[0], middle[3] - middle[1]
    assert middle[0] == pytest.approx(140, abs=1) and 145 - 2 <= middle[3] < 150
    for (left, top), label in places.items():
        assert (label[2] - label[0], label[3] - label[1]) == (wide, high), (left, top)
    assert places[-80, 150][0] == 0 and places[140, -60][1] == 0
    assert places[width - size[0] / 3, 150][2] == width - 1


def test_a_face_outside_has_no_label_and_wide_ones_fit():
    (face,) = found_in(frame_of(portrait())).faces
    frame = frame_of(grey())
    DrawFaces()(FrameFaces(frame, (moved_to(face, 5000, 100),)))
    assert (frame.planes[0] == frame_of(grey()).planes[0]).all()
    small = frame_of(grey(96, 64))
    DrawFaces()(FrameFaces(small, (moved_to(face, -60, 40),)))
    left, _, right, _ = label_of(small)
    assert 0 <= left < right <= 95


def test_a_points_file_never_replaces_another_file(tmp_path):
    src, dst = tmp_path / "in.mp4", tmp_path / "out.mp4"
    src.write_bytes(b"video")
    for name in ("in.mp4", "out.mp4", "out.part.mp4"):
        with pytest.raises(UsageError, match="own files"):
            PointsFile(tmp_path / name, src, dst, overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["in.mp4"]


@pytest.fixture
def paths(tmp_path):
    """The paths (points, src, dst) that PointsFile takes."""
    (tmp_path / "in.mp4").write_bytes(b"video")
    return tmp_path / "points.json", tmp_path / "in.mp4", tmp_path / "out.mp4"


def test_the_points_file_is_json_with_one_frame_a_line(paths):
    path = paths[0]
    with PointsFile(*paths) as file:
        draw = DrawFaces(file)
        draw(found_in(frame_of(portrait(), pts=0)))
        draw(FrameFaces(frame_of(grey(), pts=15), cut=True))
        assert not path.exists()
    stored = json.loads(path.read_text())
    first, second = stored["frames"]
    assert np.array(first["faces"][0]["points_px"]).shape == (478, 3)
    assert second == {"pts": 15, "seconds": 0.5, "cut": True, "faces": []}
    assert len(path.read_text().splitlines()) == 4


def test_a_points_file_of_no_frames_is_json_too(paths):
    with PointsFile(*paths):
        pass
    assert json.loads(paths[0].read_text())["frames"] == []


@pytest.mark.parametrize(
    ("error", "left"),
    [(StoppedError, ["in.mp4", "points.part.json"]), (OutputError, ["in.mp4"]),
     (KeyboardInterrupt, ["in.mp4"])],
)  # fmt: skip
def test_only_a_stop_leaves_the_points_so_far_as_valid_json(paths, error, left):
    with pytest.raises(error), PointsFile(*paths) as file:
        file.write(FrameFaces(frame_of(grey())))
        raise error
    assert sorted(path.name for path in paths[0].parent.iterdir()) == left
    if len(left) > 1:
        assert len(json.loads(paths[0].with_name(left[1]).read_text())["frames"]) == 1


def test_a_stop_before_the_first_frame_leaves_nothing(paths):
    with pytest.raises(StoppedError), PointsFile(*paths):
        raise StoppedError
    assert [path.name for path in paths[0].parent.iterdir()] == ["in.mp4"]


def test_a_points_file_on_a_full_disk_is_removed(paths):
    with pytest.raises(OutputError) as error, PointsFile(*paths) as file:
        file.write(FrameFaces(frame_of(grey())))
        file._file.close()
        file._file = open("/dev/full", "w")  # noqa: SIM115
        file.write(FrameFaces(frame_of(grey())))
    assert "points.json cannot be written" in str(error.value)
    assert "\n" not in str(error.value)
    assert [path.name for path in paths[0].parent.iterdir()] == ["in.mp4"]
