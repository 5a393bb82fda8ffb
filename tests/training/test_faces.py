"""Training geometry: transforms of points must match the transforms of pictures."""

from io import BytesIO
from pathlib import Path

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import find_faces
from makeup_video.pipeline.faces.net import SHIPPED, Net
from makeup_video.pipeline.faces.nets import load_nets
from makeup_video.pipeline.faces.topology import EYE, LIPS, LIPS_INNER, LIPS_OUTER, RIGHT_EYE
from makeup_video.training.faces import (
    crops,
    prepare,
)
from makeup_video.training.faces import (
    lip_evidence as lipevidence,
)
from makeup_video.training.faces import (
    lip_outlines as lipoutlines,
)
from makeup_video.training.faces.augment import jpeg
from makeup_video.training.faces.infer import crop_to_px, take
from people import SAMPLES
from PIL import Image

RNG = np.random.default_rng(0)


def test_fit_similarity_finds_the_similarity_that_was_applied():
    mean = RNG.normal(size=(478, 2)).astype(np.float32)
    linear = 40 * np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    pose = prepare.poses_of((mean @ linear.T + [100, 60])[None], mean)[0]
    assert np.allclose(pose[:, :2], linear, atol=1e-3)
    assert np.allclose(pose[:, 2], [100, 60], atol=1e-3)


def test_own_coordinates_undo_the_pose():
    mean = RNG.normal(size=(478, 3)).astype(np.float32)
    points = mean * 30 + [200, 150, 0]
    poses = prepare.poses_of(points[None, :, :2], mean[:, :2])
    back = prepare.to_own_coordinates(points[None], poses)[0]
    assert np.allclose(back[:, :2], mean[:, :2], atol=1e-4)
    assert np.allclose(back[:, 2], mean[:, 2] - mean[:, 2].mean(), atol=1e-4)


def test_depth_is_read_bilinearly_and_held_beyond_the_grid():
    ramp = np.linspace(-1, 1, prepare.DEPTH_CELLS, dtype=np.float32)
    grids = np.tile(ramp, (1, prepare.DEPTH_CELLS, 1))
    places = np.array([[[0.0, 0.3], [0.8, -0.2], [99.0, 0.0]]])
    assert np.allclose(crops.look_up(grids, places)[0], [0, 0.5, 1], atol=1e-3)


def test_stretch_keeps_a_linear_map_exact():
    rows, columns = np.mgrid[0:11, 0:13].astype(np.float32)
    w, h = 96, 80
    coarse = np.dstack([columns * (w - 1) / 12, rows * (h - 1) / 10])
    y, x = np.mgrid[0:h, 0:w]
    # cv2 interpolates in steps of 1/32 of a coarse cell
    assert np.abs(crops.stretch(coarse, (w, h)) - np.dstack([x, y])).max() < 8 / 32


@pytest.mark.parametrize("quality", [20, 60])
def test_jpeg_treats_colours_as_cameras_do(quality):
    rng = np.random.default_rng(0)
    red = rng.integers(60, 240, (12, 14, 1)) * np.array([1, 0.1, 0.3])  # fine steps of reds
    rgb8 = np.kron(red, np.ones((6, 6, 1))).astype(np.uint8)
    coded = BytesIO()
    Image.fromarray(rgb8).save(coded, "JPEG", quality=quality, subsampling="4:2:0")
    off = jpeg(rgb8, quality).astype(int) - np.asarray(Image.open(coded))
    assert np.abs(off).mean() < 1


def test_a_covered_mouth_is_masked_out_and_marked():
    mask = np.dstack([np.full((8, 8, 2), 255, np.uint8), np.zeros((8, 8, 2), np.uint8)])
    cover = np.zeros((8, 8), np.float32)
    cover[:, :4] = 1
    crops.cover_mask(mask, cover)
    assert (mask[:, :4, :2] == 0).all() and (mask[:, 4:, :2] == 255).all()
    assert (mask[:, :4, 3] == 255).all() and (mask[:, 4:, 3] == 0).all()


def test_drawn_curves_meet_their_points_with_sharp_corners():
    square = [[x, y] for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)) for _ in range(2)]
    curve = lipoutlines.spline(square)
    assert np.allclose(curve[::12][:4], square[1::2])
    assert curve.min() >= -1e-9 and curve.max() <= 1 + 1e-9  # straight sides do not bulge


def test_lips_interior_and_cover_never_overfill_a_pixel():
    mouths = lipoutlines.read_mouths((96, 72), 1.4)
    assert len(mouths) >= 40
    for mouth in mouths:
        assert (mouth.lips + mouth.interior + mouth.covered <= 1 + 1e-6).all()
        assert mouth.lips.sum() > 50


def test_enclosed_is_sure_on_lips_and_between_them_only():
    column = np.array([-5.0, 4.0, -5.0, -5.0, 3.0, -5.0])[:, None]
    assert lipevidence.enclosed(column)[:, 0].tolist() == [-5, 4, 3, 3, 3, -5]


@pytest.mark.parametrize(("name", "most"), [("mesh", 0.001), ("lips", 0.006), ("eye", 0.001)])
def test_shipped_point_nets_can_be_trained_further(name, most):
    """Integer weights come back rounded, and activations are no longer rounded."""
    restored = pytest.importorskip("makeup_video.training.faces.from_onnx", reason="needs PyTorch")
    spec = restored.SPECS[name]
    net = restored.build(name, spec.size_wh, restored.torch.zeros(200, len(spec.points), 3))
    rgb8 = crops_of(spec)
    want = Net(name)(rgb8)
    points, *_, last = computed_again(restored, net, name, rgb8)
    assert np.abs(points - want["points"])[..., :2].mean() < most  # IOD
    if name == "lips":
        assert differs_by(last, want["mask_logits"]) < 0.1


def test_the_shipped_detector_can_be_trained_further():
    restored = pytest.importorskip("makeup_video.training.faces.from_onnx", reason="needs PyTorch")
    rgb8 = np.stack([cv2.resize(portrait()[at:, at:], (192, 192)) for at in (0, 40, 80, 120)])
    (cells,) = computed_again(restored, restored.Detector(), "detector", rgb8)
    assert differs_by(cells, Net("detector")(rgb8)["cells"]) < 0.1


def differs_by(got, want):
    """The mean difference as a share of the mean size."""
    return np.abs(got - want).mean() / np.abs(want).mean()


def portrait():
    return np.ascontiguousarray(cv2.imread(str(SAMPLES / "portrait.jpg"))[..., ::-1])


def crops_of(spec):
    """(4, H, W, 3) uint8: a net's crop of the sample portrait, at four places."""
    (face,) = find_faces(portrait())
    xy = face.points_px[:, 0] + 1j * face.points_px[:, 1]
    to_px = crop_to_px(load_nets().fit_pose(xy).array(), np.array(spec.centre))
    shifts = [np.array([[0, 0, 3 * at], [0, 0, -2 * at]]) for at in range(4)]
    return np.stack([take(portrait(), to_px + shift, spec) for shift in shifts])


def computed_again(restored, net, name, rgb8):
    """The outputs of a net of PyTorch with the weights of the shipped one."""
    crops = restored.normalise(restored.torch.from_numpy(rgb8))
    restored.restore(net, Path(str(SHIPPED)) / f"{name}.onnx", crops)
    with restored.torch.no_grad():
        out = net.eval()(crops)
    return [part.numpy() for part in (out if isinstance(out, tuple) else [out])]


def test_lists_of_points_have_no_doubles():
    for points in (LIPS, EYE, RIGHT_EYE, LIPS_OUTER, LIPS_INNER):
        assert len(set(points.tolist())) == len(points)


def test_detector_targets_decode_to_the_same_faces():
    detect = pytest.importorskip(
        "makeup_video.training.faces.train_detector", reason="needs PyTorch"
    )
    faces = np.array([[60.0, 80.0, 30.0, 0.2], [190.0, 170.0, 12.0, -0.4]], np.float32)
    heat, values = detect.targets(faces)
    cells = np.concatenate([np.log((heat + 1e-3) / (1 - heat + 1e-3))[None], values[:5]])
    poses = detect.decode(cells, 1.0, threshold=0.9)
    assert len(poses) == 2
    for x, y, unit, turn in faces:
        gaps = [np.hypot(*(f @ [*detect.FACE_CENTRE, 1] - [x, y])) for f in poses]
        pose = poses[int(np.argmin(gaps))]
        assert min(gaps) < 0.01
        assert np.allclose(pose[:, 0], unit * np.array([np.cos(turn), np.sin(turn)]), rtol=1e-4)


def test_wrong_detections_are_told_from_the_face_itself():
    score = pytest.importorskip(
        "makeup_video.training.faces.train_face_score", reason="needs PyTorch"
    )
    middle, unit = np.array([200.0, 150.0]), 60.0

    def guess(x: float, y: float, size: float) -> np.ndarray:
        linear = size * np.eye(2)
        return np.column_stack([linear, np.array([x, y]) - linear @ [0, 0.42]])

    assert not score._is_elsewhere(guess(205, 146, 55), middle, unit)
    assert score._is_elsewhere(guess(300, 150, 60), middle, unit)  # beside the face
    assert score._is_elsewhere(guess(200, 190, 25), middle, unit)  # its chin
    assert score._is_elsewhere(guess(200, 150, 20), middle, unit)  # its nose


@pytest.mark.parametrize("height_px", [700, 811, 950])  # one side is no multiple of 32
def test_mistakes_lie_at_the_same_place_at_any_height(height_px):
    score = pytest.importorskip(
        "makeup_video.training.faces.train_face_score", reason="needs PyTorch"
    )
    square, centre = portrait()[:1024], [*score.FACE_CENTRE, 1]
    face, *_ = score._detections(load_nets(), square, 256)
    found = score._detections(load_nets(), square[:height_px], 256)
    off = np.min([np.hypot(*(pose @ centre - face @ centre)) for pose in found])
    assert off < 0.02 * np.hypot(*face[:, 0])  # the picture below a face shifts its place a little


def test_a_quantised_convolution_stays_close_on_256_values():
    model = pytest.importorskip("makeup_video.training.faces.model", reason="needs PyTorch")
    from makeup_video.training.faces.fake_quantise import rounded, roundings

    torch = model.torch
    torch.manual_seed(0)
    net = torch.nn.Sequential(model.Conv(3, 8, 2), model.Residual(8)).eval()
    x = torch.randint(0, 256, (2, 3, 16, 24)).float()
    with torch.no_grad():
        want = net(x / 127.5 - 1)
        rounded(net)
        net((x - 128) / 127.5)  # observes the ranges
        for rounding in roundings(net):
            rounding.settle()
        got = net((x - 128) / 127.5)
    assert len(got.unique()) <= 256
    inside = slice(1, None), slice(1, None)  # at the border grey is 128, not 127.5
    off = (got - want)[:, :, *inside].abs()
    assert off.mean() < 0.02 * want.max()


def test_a_net_laid_out_for_integers_gives_the_same_output():
    model = pytest.importorskip("makeup_video.training.faces.model", reason="needs PyTorch")
    from makeup_video.training.faces import export_int8 as integers
    from makeup_video.training.faces import fake_quantise as rounded

    torch = model.torch
    torch.manual_seed(1)
    size_wh = (32, 16)
    net = model.LipNet(size_wh, (8, 24, 24, 32), (0, 1, 1, 1), torch.zeros(5, 3), torch.ones(4, 15))
    net = rounded.rounded(net)
    rgb8 = torch.randint(0, 256, (2, 16, 32, 3), dtype=torch.uint8)
    x = (rgb8.permute(0, 3, 1, 2).float() - 128) / 127.5
    with torch.no_grad():
        net(x)
        for rounding in rounded.roundings(net):
            rounding.settle()
        points, _, mask = net(x)
        got_points, got_mask = integers.Integers(net, ["points", "mask_logits"])(rgb8)
    assert torch.allclose(got_points, points, atol=1e-4)
    step = float(net.paint[0].round.scale)  # of an answer: they are rounded from another start
    assert float((got_mask - mask).abs().max()) < 1.5 * step * model.SHARPER


def test_kept_parts_stay_float_and_fitted_ranges_are_closer():
    model = pytest.importorskip("makeup_video.training.faces.model", reason="needs PyTorch")
    from makeup_video.training.faces import (
        export_int8 as integers,
    )
    from makeup_video.training.faces import (
        fake_quantise as rounded,
    )
    from makeup_video.training.faces import (
        train_quantised as quantise,
    )

    torch = model.torch
    torch.manual_seed(2)
    shape = (32, 16), (8, 16, 16), (0, 1, 1), torch.zeros(5, 3), torch.ones(4, 15)
    teacher = model.PointNet(*shape).eval()
    net = model.PointNet(*shape).eval()
    net.load_state_dict(teacher.state_dict())
    net = rounded.rounded(net, ("stages.2", "points"))
    kinds = {name for name, part in net.named_modules() if isinstance(part, rounded.RoundedWeights)}
    assert kinds == {"stages.0.0", "stages.1.0", "stages.1.1.body.0", "stages.1.1.body.1"}

    rgb8 = torch.randint(0, 256, (4, 16, 32, 3), dtype=torch.uint8)
    with torch.no_grad():
        expected = teacher(model.normalise(rgb8))
        net(quantise.codes(rgb8))  # observes the ranges
        for rounding in rounded.roundings(net):
            rounding.highest *= 20  # as an outlier would
            rounding.settle()
        before = quantise.difference("mesh", net(quantise.codes(rgb8)), expected)
        for _ in range(2):
            quantise.fit_ranges("mesh", teacher, net, rgb8)
        calibrated = net(quantise.codes(rgb8))
        assert quantise.difference("mesh", calibrated, expected) < before
        got = integers.Integers(net, ["points", "scores"])(rgb8)
    assert torch.allclose(got[0], calibrated[0], atol=1e-4)


def test_a_finished_run_says_so_rather_than_train_nothing(tmp_path):
    checkpoint = pytest.importorskip("makeup_video.training.faces.checkpoint")
    import torch

    net = torch.nn.Linear(2, 1)
    optimizer = torch.optim.SGD(net.parameters(), lr=0.1)
    run = checkpoint.Checkpoint(tmp_path / "net.pt", net, optimizer, 0.9)
    run.resume(3)  # nothing to resume
    for _ in range(3):
        run.learn(net(torch.ones(1, 2)).sum(), 0.1, clip=1.0)
    run.save(("net", 1))
    for left, steps in ((1, 4), (7, 10)):
        again = checkpoint.Checkpoint(tmp_path / "net.pt", net, optimizer, 0.9)
        again.resume(steps)
        assert steps - again.step == left
    with pytest.raises(SystemExit, match="finished: it has 3 steps, and 3 were asked for; move it"):
        run.resume(3)
