"""Painting videos, picture files and arrays: which faces are painted, and what stays as it is."""

import linecache
import subprocess
import sys
from dataclasses import replace

import cv2
import numpy as np
import pyopencl as cl
import pytest
from lit_faces import lit
from makeup_video.kernels.colour import SRGB, to_linear, to_xyz
from makeup_video.pipeline import (
    InstallError,
    Layer,
    Look,
    PhotoError,
    Settings,
    UsageError,
    apply_look,
    estimate_look,
    find_faces,
    process_video,
    product,
)
from makeup_video.pipeline.faces.lip_mask import lip_mask
from makeup_video.pipeline.render import composite
from makeup_video.pipeline.render.apply_look import PaintPictures
from media import decoded, make_clip
from people import SAMPLES, clip, clip_points, face_of, grey, portrait, put, write_video
from picture_files import read_picture

RED = Look(lips=product((192, 32, 64), "matte"))
BLUE = Look(lips=product((10, 42, 140), "matte"))
BOTH = Look(lips=product((10, 42, 140), "matte"), eyes=product((0, 90, 40), "matte", "eyes"))


def two_people():
    return put(put(grey(), face_of(80), 40, 60), face_of(110), 320, 60)


def box_of(face):
    """Return the slices of rows and columns that hold all that is painted on a face."""
    low, high = face.points_px[:, :2].min(0), face.points_px[:, :2].max(0)
    return np.s_[int(low[1]) : int(high[1]) + 2, int(low[0]) : int(high[0]) + 2]


def changed(before, after):
    return (before != after).any(axis=2)


def test_a_video_is_painted_on_the_face_and_nowhere_else(tmp_path):
    src, dst = write_video(tmp_path / "in.mkv", clip(6)), tmp_path / "out.mkv"
    report = process_video(src, dst, BLUE, Settings(codec="ffv1"))
    assert (report.painted_frames, report.frames_with_face, report.faces) == (6, 6, 1)
    assert report.warnings() == []
    names = ["decode", "faces", "smooth", "scene", "composite", "encode"]
    assert list(report.stages) == names
    for old, new, points in zip(decoded(src), decoded(dst), clip_points()[:6], strict=True):
        luma = [np.asarray(p.to_ndarray()[:360], int) for p in (old, new)]
        moved = luma[0] != luma[1]
        mouth = points[[61, 291]].mean(0).astype(int)
        assert moved[mouth[1] - 12 : mouth[1] + 12, mouth[0] - 20 : mouth[0] + 20].any()
        low, high = points.min(0).astype(int) - 20, points.max(0).astype(int) + 20
        moved[low[1] : high[1], low[0] : high[0]] = False
        assert not moved.any()


def test_a_kept_painter_paints_each_picture_as_a_new_one_does():
    paint = PaintPictures()
    for rgb8, look in (
        (portrait(), BLUE),
        (clip(1)[0], BOTH),
        (portrait(), Look()),
        (portrait(), BOTH),
    ):
        np.testing.assert_array_equal(paint(rgb8, look), apply_look(rgb8, look))


def test_lips_alone_leave_the_eyes_alone():
    face = find_faces(portrait())[0]
    middle = int(face.points_px[4, 1])  # the tip of the nose
    lips, both = apply_look(portrait(), BLUE), apply_look(portrait(), BOTH)
    assert not changed(portrait(), lips)[:middle].any()
    assert changed(portrait(), lips)[middle:].any()
    assert changed(portrait(), both)[:middle].any()
    np.testing.assert_array_equal(lips[middle:], both[middle:])


@pytest.mark.parametrize("exposure", [1, 0.7, 0.5, 0.35, 0.25])
def test_lipstick_does_not_glow_on_a_face_in_the_dark(exposure):
    dim = lit(exposure, exposure, exposure)
    face = find_faces(dim)[0]
    lips = lip_mask(dim, face) > 0.95
    cheeks = np.rint(face.points_px[[50, 280], :2]).astype(int)
    painted, skin = (
        to_linear(codes / 255, SRGB).mean(0) @ to_xyz(1)[1]
        for codes in (apply_look(dim, RED)[lips], dim[cheeks[:, 1], cheeks[:, 0]])
    )
    assert 0.3 < painted / skin < 0.6  # 0.44 in full light


def test_apply_look_returns_a_copy_changed_only_on_the_face():
    before = portrait().copy()
    painted = apply_look(before, BOTH)
    np.testing.assert_array_equal(before, portrait())
    assert painted.shape == before.shape and painted.dtype == np.uint8
    assert painted.flags.c_contiguous and painted.flags.writeable
    moved = changed(before, painted)
    assert moved.any()
    moved[box_of(find_faces(before)[0])] = False
    assert not moved.any()


def test_picture_files_and_arrays_are_painted_alike(tmp_path):
    cv2.imwrite(str(tmp_path / "in.png"), portrait()[..., ::-1])
    report = process_video(tmp_path / "in.png", tmp_path / "out.png", BOTH)
    assert (report.painted_frames, report.faces, report.frames_with_face) == (1, 1, 1)
    got = cv2.imread(str(tmp_path / "out.png"))[..., ::-1]
    np.testing.assert_array_equal(got, apply_look(portrait(), BOTH))


@pytest.mark.parametrize("shape", [(600, 512, 3), (600, 512, 4), (600, 512, 1)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_compared_pictures_hold_the_original_pixels_exactly(tmp_path, shape, dtype):
    grey8 = portrait().mean(2).astype(np.uint8)[..., None]
    stored = {1: grey8, 3: portrait()[..., ::-1],
              4: np.concatenate([portrait()[..., ::-1], grey8], 2)}[shape[2]]  # fmt: skip
    stored = stored.astype(dtype) * (257 if dtype == np.uint16 else 1)
    cv2.imwrite(str(tmp_path / "in.png"), stored)
    process_video(tmp_path / "in.png", tmp_path / "plain.png", BLUE)
    process_video(tmp_path / "in.png", tmp_path / "both.png", BLUE, Settings(compare=True))
    both, plain = (read_picture(tmp_path / f"{name}.png")[0] for name in ("both", "plain"))
    assert both.dtype == dtype and both.shape == (600, 1024, max(shape[2], 3))
    np.testing.assert_array_equal(both[:, :512], np.broadcast_to(stored, plain.shape))
    np.testing.assert_array_equal(both[:, 512:], plain)
    assert (both[:, :512] != both[:, 512:]).any()


def test_a_comparison_that_paints_nothing_needs_no_face(tmp_path):
    cv2.imwrite(str(tmp_path / "in.png"), grey(31, 17))
    report = process_video(tmp_path / "in.png", tmp_path / "o.png", None, Settings(compare=True))
    assert cv2.imread(str(tmp_path / "o.png")).shape == (17, 62, 3)
    assert report.faces is None and report.warnings() == []


def test_only_the_largest_or_the_numbered_face_is_painted(tmp_path):
    picture = two_people()
    cv2.imwrite(str(tmp_path / "in.png"), picture[..., ::-1])
    large, small = find_faces(picture)
    for chosen, painted, other in (
        ("largest", large, small),
        (str(large.track_id), large, small),
        (str(small.track_id), small, large),
    ):
        process_video(
            tmp_path / "in.png", tmp_path / "o.png", BLUE, Settings(faces=chosen, overwrite=True)
        )
        moved = changed(picture, cv2.imread(str(tmp_path / "o.png"))[..., ::-1])
        assert moved[box_of(painted)].any() and not moved[box_of(other)].any()


def test_faces_that_are_given_are_painted_and_no_others():
    picture = two_people()
    large, small = find_faces(picture)
    moved = changed(picture, apply_look(picture, BLUE, [small]))
    assert moved[box_of(small)].any() and not moved[box_of(large)].any()
    moved = changed(picture, apply_look(picture, BLUE, [small, large]))
    assert moved[box_of(small)].any() and moved[box_of(large)].any()


@pytest.mark.parametrize("look", [Look(), Look(lips=BLUE.lips, strength=0)])
def test_a_bare_look_and_no_face_give_a_copy(look):
    for picture, wanted in ((portrait(), look), (grey(), BLUE)):
        got = apply_look(picture, wanted)
        assert got is not picture and not np.shares_memory(got, picture)
        np.testing.assert_array_equal(got, picture)
    np.testing.assert_array_equal(apply_look(portrait(), BLUE, ()), portrait())


@pytest.mark.parametrize("wrong", [np.zeros((8, 8), np.uint8), np.zeros((8, 8, 3), np.float32)])
def test_anything_but_rgb8_is_refused(wrong):
    for look in (Look(), BLUE):
        with pytest.raises(ValueError, match="uint8"):
            apply_look(wrong, look)


@pytest.mark.parametrize("name", ["in.mp4", "in.png"])
def test_a_video_without_a_face_is_not_painted_and_warned_of(tmp_path, name):
    if name == "in.png":
        cv2.imwrite(str(tmp_path / name), grey())
    else:
        make_clip(tmp_path / name)
    report = process_video(tmp_path / name, tmp_path / f"out{name[2:]}", BLUE)
    assert (report.painted_frames, report.faces) == (0, 0)
    kind = "picture" if name == "in.png" else "video"
    warning = f"no face was found: nothing was painted; if the {kind} is upside down, turn it first"
    assert report.warnings() == [warning]
    assert report.to_dict()["painted_frames"] == 0


@pytest.mark.parametrize("faces", ["", "none", "-1", "1.5", "ALL", "1,2", "\uff11"])
def test_faces_must_be_all_largest_or_a_number(faces):
    with pytest.raises(UsageError, match="faces must be all, largest, or the number"):
        Settings(faces=faces)


@pytest.mark.parametrize("name", ["in.mkv", "in.jpg"])
def test_a_missing_device_is_refused_before_the_work(tmp_path, monkeypatch, name):
    if name == "in.jpg":
        (tmp_path / name).write_bytes((SAMPLES / "portrait.jpg").read_bytes())
    else:
        write_video(tmp_path / name, clip(2))
    target = tmp_path / f"out.{name}"
    with pytest.raises(UsageError, match="no such device"):
        process_video(tmp_path / name, target, BLUE, Settings(device="no such device"))
    monkeypatch.setattr(cl, "get_platforms", list)
    with pytest.raises(InstallError, match="pocl-binary-distribution"):
        process_video(tmp_path / name, target, BLUE)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    process_video(tmp_path / name, target, Look(), Settings(device="no such device"))


def test_public_names_load_their_libraries_only_when_used():
    code = (
        "import sys; from makeup_video.pipeline import FINISHES, Look, product\n"
        "from makeup_video.pipeline.look.options import Choice, choose_look\n"
        "look = choose_look(Choice(color='B02', finish='gloss'))\n"
        "assert look == Look(lips=product((187, 0, 34), 'gloss'))\n"
        "heavy = {'cv2', 'onnxruntime', 'pyopencl'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "from makeup_video.pipeline import find_faces\n"
        "assert 'pyopencl' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_many_pictures_load_the_kernels_once():
    rgb8, faces = portrait(), find_faces(portrait())
    apply_look(rgb8, RED, faces)
    loaded = len(linecache.cache)
    for _ in range(3):
        apply_look(rgb8, BLUE, faces)
    assert len(linecache.cache) == loaded


def test_charts_of_a_look_are_drawn_once_for_many_pictures(monkeypatch):
    drawn, groups_of = [], composite.groups_of
    monkeypatch.setattr(composite, "groups_of", lambda layers: drawn.append(1) or groups_of(layers))
    paint, faces = PaintPictures(), find_faces(portrait())
    for look in (BOTH, BOTH, RED, RED, BOTH):
        paint(portrait(), look, faces)
    assert len(drawn) == 3


def test_what_is_no_face_is_refused_with_what_to_give():
    rgb8, (face, *_) = portrait(), find_faces(portrait())
    with pytest.raises(TypeError, match=r"got one Face: give \[face\]"):
        apply_look(rgb8, RED, face)
    for take in (lip_mask, estimate_look):
        with pytest.raises(TypeError, match=r"got tuple: give one of them, such as faces\[0\]"):
            take(rgb8, (face,))
    for take in (lip_mask, estimate_look, lambda rgb8, face: apply_look(rgb8, RED, [face])):
        with pytest.raises(TypeError, match="got int: find_faces"):
            take(rgb8, 3)


@pytest.mark.parametrize("flaw", [np.nan, 1e20])
def test_a_face_that_cannot_be_painted_is_left_alone(flaw):
    rgb8, (face, *_) = portrait(), find_faces(portrait())
    points = face.points_px.copy()
    points[40] = flaw
    broken = replace(face, points_px=points)
    np.testing.assert_array_equal(apply_look(rgb8, BOTH, [broken]), rgb8)


def test_a_face_that_is_given_twice_is_painted_once():
    rgb8, (face, *_) = portrait(), find_faces(portrait())
    once = apply_look(rgb8, BOTH, [face])
    np.testing.assert_array_equal(apply_look(rgb8, BOTH, [face, face]), once)


def test_no_look_is_read_from_a_face_that_is_not_finite():
    rgb8, (face, *_) = portrait(), find_faces(portrait())
    points = face.points_px.copy()
    points[5] = np.nan
    with pytest.raises(PhotoError, match="not finite: give one of find_faces"):
        estimate_look(rgb8, replace(face, points_px=points))


def test_lips_whose_patch_has_no_area_are_left_alone():
    rgb8, (face, *_) = portrait(), find_faces(portrait())
    flat = replace(face, lips=replace(face.lips, to_px=np.zeros((2, 3))))
    np.testing.assert_array_equal(apply_look(rgb8, RED, [flat]), rgb8)


def test_a_liner_of_no_thickness_has_no_wing():
    rgb8, faces = portrait(), find_faces(portrait())
    inked = [
        changed(rgb8, apply_look(rgb8, Look([liner(thickness)]), faces)).sum()
        for thickness in (0.0, 0.001, 0.01, 0.04, 0.1)
    ]
    assert inked[0] == 0 and inked == sorted(inked)


def liner(thickness: float) -> Layer:
    black = product("#120E0E", "matte", "liner")
    return Layer("eyeliner", black, {"thickness": thickness, "wing": 0.3})
