"""Training of the net that reads eyeliner: drawn truth, varied corners, and the shipped net."""

from argparse import Namespace
from dataclasses import replace
from math import nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Layer, Look, product
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.reference.read_liner import (
    ANGLE_UNIT,
    CORNER_WH,
    CORNER_XY,
    EYE_PX,
    corner_inputs,
)
from makeup_video.training.worn.corner import NUMBERS, lids_of
from makeup_video.training.worn.draw_looks import draw_look
from makeup_video.training.worn.liner_crops import SHARES, corners_of, labelled_liners, target_of
from makeup_video.training.worn.vary_corners import varied
from packed_crops import numbers_shown
from people import portrait
from reference_photos import face


def liner(strength=1.0, **shape):
    worn = product((10, 10, 10), "matte", "liner")
    return Look([Layer("eyeliner", worn, shape, strength)])


def test_the_target_of_a_look_is_its_liner():
    assert target_of(Look()) == same((0, 0, nan, nan, nan))
    assert target_of(liner()) == same((1, 0, nan, nan, nan))
    whole = liner(wing=0.4, wing_angle=15.0)
    assert target_of(whole) == same((1, 1, 0.4, 15 / ANGLE_UNIT, nan))


def same(numbers):
    return pytest.approx(numbers, nan_ok=True)


def test_a_liner_too_sheer_to_see_is_no_target():
    assert target_of(liner(strength=0.2, wing=0.4)) == target_of(Look())


def corner(*target):
    """The right eye's corner of a portrait, with a target."""
    return next(corners_of(portrait(), face(), [target, None]))


@given(seed=st.integers(0, 2**32 - 1))
def test_varied_corners_stay_pictures_with_their_target(seed):
    given_ = corner(1, 1, 0.3, 0.2, 0.1)
    seen, target = varied(given_, np.random.default_rng(seed))
    assert seen.shape == (*CORNER_WH[::-1], 3) and seen.dtype == np.uint8
    assert seen.std() > 1 and np.array_equal(target, given_.target, equal_nan=True)
    assert (seen == varied(given_, np.random.default_rng(seed))[0]).all()


def test_corners_without_a_wing_often_get_one_that_is_dark():
    bare, rng = corner(*target_of(Look())), np.random.default_rng(3)
    right = np.s_[30:54, 78:96]  # where wings lie
    light = {0: [], 1: []}
    for _ in range(200):
        seen, target = varied(bare, rng)
        assert target.dtype == np.float32 and target[1] in (0, 1)
        if target[1]:
            assert target[0] == 1 and 0.08 <= target[2] <= 0.63 and abs(target[3]) <= 1
            assert np.isnan(target[4])
        light[int(target[1])].append(np.median(seen[right]) / np.median(seen))
    assert 0.2 < len(light[1]) / 200 < 0.5
    assert np.mean(light[1]) < np.mean(light[0])


def test_lids_run_from_the_outer_corner_to_the_inner_one():
    lids = lids_of(face())
    assert lids.shape == (2, 2, 9, 2) and lids.dtype == np.float32
    inner = (CORNER_XY[0] - EYE_PX, CORNER_XY[1])
    for upper, lower in lids:
        for lid in (upper, lower):
            assert lid[0] == pytest.approx(CORNER_XY, abs=0.01)
            assert lid[-1] == pytest.approx(inner, abs=0.01)
        assert upper[4, 1] < lower[4, 1]


def test_eyes_without_a_target_and_small_ones_are_left_out():
    whole = list(corners_of(portrait(), face(), [(1, 1, nan, nan, 0.1), None]))
    assert len(whole) == 1 and whole[0].target[:2].tolist() == [1, 1]
    small = face()
    small = replace(small, points_px=small.points_px * np.float32(0.1))
    assert not list(corners_of(portrait(), small, [target_of(Look())] * 2))


def test_labels_of_liners_are_shares_or_unknown():
    targets = [one for both in labelled_liners().values() for one in both if one is not None]
    assert len(targets) > 600 and {len(one) for one in targets} == {len(NUMBERS)}
    known = np.array(targets)
    assert np.isin(known[np.isfinite(known[:, 1]), 1], [0, 1]).all()
    thickness = known[np.isfinite(known[:, 4]), 4]
    assert len(thickness) > 600 and (thickness >= 0).all() and (thickness <= 1).all()


def test_drawn_looks_wear_the_kinds_that_were_asked_for():
    rng = np.random.default_rng(1)
    kinds = {layer.kind for _ in range(40) for layer in draw_look(rng, {}, SHARES).layers}
    assert kinds == set(SHARES)


def packed(path, count=100, real=4):
    """Corners whose first value is their number; the last ones are real, every second winged."""
    numbered = [np.full((*CORNER_WH[::-1], 3), number, np.uint8) for number in range(count)]
    target = np.float32([target_of(liner(wing=0.4)), target_of(Look())] * (count // 2))
    is_real = np.arange(count) >= count - real
    lids = np.zeros((count, 2, 9, 2), np.float32)
    face = np.where(is_real, -1, np.arange(count))
    np.savez(path, rgb8=np.stack(numbered), target=target, lids=lids, is_real=is_real, face=face)


def test_a_resumed_run_draws_other_examples(tmp_path, monkeypatch):
    pytest.importorskip("torch")
    pytest.importorskip("onnx")
    from makeup_video.training.worn import form_net, train_liner

    drawn = []

    def noted(one, rng):
        drawn.append((int(one.rgb8[0, 0, 0]), rng.random(), float(train_liner.torch.rand(()))))
        return one.rgb8, one.target

    monkeypatch.setattr(train_liner, "varied", noted)
    packed(tmp_path / "data.npz")
    for steps in (1, 2):
        files = {"data": tmp_path / "data.npz", "out": tmp_path / "net.onnx"}
        train_liner.train(Namespace(**files, steps=steps, threads=2))
    assert len(drawn) == 2 * form_net.BATCH
    first, second = (zip(*half, strict=True) for half in np.split(np.array(drawn), 2))
    assert all(one != other for one, other in zip(first, second, strict=True))


@pytest.mark.parametrize("real", [0, 4])
def test_batches_hold_real_corners_and_none_that_are_held_out(tmp_path, real, monkeypatch):
    pytest.importorskip("torch")
    from makeup_video.training.worn import train_liner

    monkeypatch.setattr(train_liner, "varied", lambda one, rng: (one.rgb8, one.target))
    packed(tmp_path / "data.npz", real=real)
    of_real = (numbers_shown(train_liner.Corners(tmp_path / "data.npz")) >= 100 - real).mean()
    assert of_real == pytest.approx(sum(train_liner.SHARES[1:]) if real else 0, abs=0.03)


@pytest.mark.parametrize("column", range(len(NUMBERS)))
def test_what_is_unknown_costs_nothing(column):
    torch = pytest.importorskip("torch")
    from makeup_video.training.worn.train_liner import loss_of

    true = torch.tensor([[1.0, 1.0, 0.3, 0.2, 0.1]])
    off = torch.full((1, len(NUMBERS)), 0.4)
    off[0, column] = -3.0
    unknown = true.clone()
    unknown[0, column] = nan
    near = off.clone()
    near[0, column] = true[0, column]
    assert loss_of(off, unknown) == loss_of(near, unknown)
    assert loss_of(near, true) < loss_of(off, true)


def test_the_shipped_net_is_one_that_this_training_exports(tmp_path):
    torch = pytest.importorskip("torch")
    pytest.importorskip("onnx")
    from makeup_video.training.worn.train_liner import LinerNet, export, loss_of, report

    inputs = corner_inputs(portrait(), face())[0]
    net = LinerNet().eval()
    export(net, tmp_path / "liner.onnx")
    import onnxruntime

    session = onnxruntime.InferenceSession(str(tmp_path / "liner.onnx"))
    found = session.run(None, {"rgb8": inputs})[0]
    net.eval()
    with torch.no_grad():
        assert found == pytest.approx(net(torch.from_numpy(inputs)).numpy(), abs=1e-4)
    assert Net("reference_liner")(inputs)["liner"].shape == found.shape
    targets = np.float32([target_of(liner(wing=0.4)), target_of(Look())])
    loss = loss_of(net.all_numbers(torch.from_numpy(inputs)), torch.from_numpy(targets))
    assert float(loss) > 0
    assert "wing " in report(net, inputs, targets)
