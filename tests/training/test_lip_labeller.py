"""The labeller of lip masks: labels move with the picture, and a fitted labeller finds them."""

import cv2
import numpy as np
import pytest

labeller = pytest.importorskip("makeup_video.training.faces.lip_labeller", reason="needs PyTorch")
torch = labeller.torch
HIGH, WIDE = 112, 144


def mouths(count: int) -> tuple[np.ndarray, "labeller.Labels"]:
    """Inputs (colours, log-odds of mouth and opening) of drawn mouths, and their labels."""
    rng = np.random.default_rng(5)
    shares = np.zeros((count, 3, HIGH, WIDE), np.float32)
    for mouth in shares:
        middle = (72 + int(rng.integers(-9, 9)), 56 + int(rng.integers(-9, 9)))
        for part, axes in zip(mouth, ((45, 24), (28, 10), (28, 4)), strict=True):
            cv2.ellipse(part, middle, axes, 0, 0, 360, 1.0, -1)
    colours = rng.uniform(-1, 0, (count, 3, HIGH, WIDE)) + shares[:, 2:]  # teeth are light
    inputs = np.concatenate([colours, 6 * shares[:, :2] - 3], 1, dtype=np.float32)
    known = torch.ones(count, HIGH, WIDE)
    return inputs, labeller.Labels(torch.from_numpy(shares), known)


def test_labels_move_with_the_picture(monkeypatch):
    monkeypatch.setattr(labeller, "NOISE", (0.0, 0.0))
    monkeypatch.setattr(labeller, "LEFT_OUT", 0.0)
    inputs, labels = mouths(6)
    net = labeller.Labeller(inputs.shape[1])
    moved, shares = labeller.augmented(
        torch.from_numpy(inputs), labels, net, np.random.default_rng(1)
    )
    seen = (moved[:, 3:] + 3) / 6
    assert float((seen - shares.shares[:, :2]).abs().max()) < 1e-4
    assert float((shares.shares - labels.shares).abs().mean()) > 0.02


def test_a_fitted_labeller_finds_mouth_opening_and_teeth(monkeypatch):
    for name, value in {"EPOCHS": 60, "WARM_UP": 5, "AVERAGE": 0.8}.items():  # 30 steps
        monkeypatch.setattr(labeller, name, value)
    inputs, labels = mouths(8)
    net = labeller.fit(inputs, labels)
    whole = np.zeros((144, 192, 5), np.float32)
    whole[labeller.WINDOW] = inputs[0].transpose(1, 2, 0)
    crop = np.rint((whole[..., :3] + 1) * 127.5).astype(np.uint8)
    found, sure = labeller.label(net, whole[..., 3:], crop)
    window, drawn = found[labeller.WINDOW] > 127, labels.shares[0].numpy().transpose(1, 2, 0) > 0.5
    assert (window[..., :2] == drawn[..., :2]).mean() > 0.97
    inside = drawn[..., 1]
    assert (window[..., 2] == drawn[..., 2])[inside].mean() > 0.8
    assert not found[:10].any()  # beyond the window
    assert 0 < sure <= 1


def test_unknown_teeth_and_tongues_teach_nothing():
    logits = torch.zeros(1, 3, 8, 8)
    shares = torch.ones(1, 3, 8, 8)
    known = torch.ones(1, 8, 8)
    unsure = shares.clone()
    unsure[:, 2] = 0.5
    one, other = torch.zeros_like(logits), torch.zeros_like(logits)
    other[:, 2] = 5
    losses = [labeller.cross_entropy_of(each, unsure, known).item() for each in (one, other)]
    assert losses[0] == pytest.approx(losses[1])
    losses = [labeller.cross_entropy_of(each, shares, known).item() for each in (one, other)]
    assert losses[1] < losses[0]
