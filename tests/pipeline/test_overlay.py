"""The drawing shows what was found, in every layout, and leaves faceless frames alone."""

import json
from dataclasses import replace

import numpy as np
import pytest
from makeup_video.pipeline import FrameFaces, OutputError
from makeup_video.pipeline.faces import find_faces_in_frame
from makeup_video.pipeline.overlay import DrawFaces, PointsFile
from people import frame_of, grey, portrait


def difference(frame, before) -> np.ndarray:
    luma = frame.planes[0]
    return luma.astype(int) != before.planes[0].astype(int)


@pytest.mark.parametrize(
    "pix_fmt", ["yuv420p", "yuv422p", "yuv444p", "nv12", "yuv420p10le", "gray"]
)
@pytest.mark.parametrize("rotation", [0, 90, 270])
def test_points_lips_and_label_are_drawn_in_every_layout(pix_fmt, rotation):
    how = {"pix_fmt": pix_fmt, "rotation_degrees": rotation}
    plain = frame_of(portrait(), **how)
    item = find_faces_in_frame(frame_of(portrait(), **how))
    drawn = DrawFaces()(item)
    assert drawn is item.frame
    changed = difference(drawn, plain)
    for x, y in item.faces[0].points_px[:, :2]:
        around = changed[max(round(y) - 1, 0) : round(y) + 2, max(round(x) - 1, 0) : round(x) + 2]
        assert around.any()
    assert 0.005 < changed.mean() < 0.2
    assert drawn.planes[0].max() <= 255 << (plain.bit_depth - 8)


def test_a_frame_without_a_face_keeps_every_byte():
    frame = frame_of(grey())
    before = [plane.copy() for plane in frame.planes]
    DrawFaces()(FrameFaces(frame))
    assert all((a == b).all() for a, b in zip(before, frame.planes, strict=True))


@pytest.mark.parametrize("shift", [(-160, -260), (200, 0), (0, 300), (5000, 5000), (-5000, 0)])
def test_a_face_that_lies_partly_or_wholly_outside_does_no_harm(shift):
    (face,) = find_faces_in_frame(frame_of(portrait())).faces
    points = face.points_px + np.array([*shift, 0], np.float32)
    to_px = face.lips.to_px + np.array([[0, 0, shift[0]], [0, 0, shift[1]]])
    moved = replace(face, points_px=points, lips=replace(face.lips, to_px=to_px))
    for pix_fmt in ("yuv420p", "nv12"):
        DrawFaces()(FrameFaces(frame_of(portrait(), pix_fmt=pix_fmt), (moved,)))


def test_the_points_file_is_json_with_one_frame_a_line(tmp_path):
    path = tmp_path / "points.json"
    file = PointsFile(path)
    draw = DrawFaces(file)
    draw(find_faces_in_frame(frame_of(portrait(), pts=0)))
    draw(FrameFaces(frame_of(grey(), pts=15), cut=True))
    file.close()
    stored = json.loads(path.read_text())
    first, second = stored["frames"]
    assert np.array(first["faces"][0]["points_px"]).shape == (478, 3)
    assert second == {"pts": 15, "seconds": 0.5, "cut": True, "faces": []}
    assert len(path.read_text().splitlines()) == 4


def test_a_points_file_that_cannot_be_written_is_told_in_one_line(tmp_path):
    file = PointsFile(tmp_path / "missing" / "points.json")
    with pytest.raises(OutputError) as error:
        file.write(FrameFaces(frame_of(grey())))
    assert "points.json" in str(error.value)
    assert "\n" not in str(error.value)
