"""Exports, and what is measured of nets: nothing old is written, nothing learned is measured."""

import os
from unittest.mock import patch

import numpy as np
import pytest

torch = pytest.importorskip("torch")
export = pytest.importorskip("makeup_video.training.faces.export", reason="needs PyTorch")
from makeup_video.training.faces import evaluate_detector, evaluate_lip_mask
from makeup_video.training.faces.lip_outlines import Mouth


def test_integers_of_an_older_net_are_not_exported(tmp_path):
    source, integers = tmp_path / "lips.pt", tmp_path / "lips_int8.pt"
    for path in (source, integers):
        path.write_bytes(b"weights")
    os.utime(integers, (1, 1))
    with pytest.raises(SystemExit, match=r"lips_int8\.pt is older than .*lips\.pt.*train_quant"):
        export.write("lips", source, tmp_path / "lips.onnx", np.zeros((1, 80, 112, 3), np.uint8))
    assert not (tmp_path / "lips.onnx").exists()


def test_an_export_that_differs_leaves_the_old_file(tmp_path, monkeypatch):
    class Mean(torch.nn.Module):
        def forward(self, rgb8):
            return rgb8.float().mean((1, 2))

    path = tmp_path / "eye.onnx"
    path.write_bytes(b"old")
    monkeypatch.setattr(export, "from_onnx", lambda path: lambda crops: [np.full((4, 3), 9.0)])
    with pytest.raises(SystemExit, match=r"eye\.onnx: ONNX Runtime and PyTorch disagree in points"):
        export.to_onnx(Mean(), path, np.zeros((4, 8, 8, 3), np.uint8), ["points"], {})
    assert path.read_bytes() == b"old" and list(tmp_path.iterdir()) == [path]


def test_old_integers_stop_an_export_before_it_writes(tmp_path, monkeypatch):
    for name in ("mesh.pt", "lips.pt", "lips_int8.pt"):
        (tmp_path / name).write_bytes(b"weights")
    os.utime(tmp_path / "lips_int8.pt", (1, 1))
    (tmp_path / "faces.npz").touch()
    out = tmp_path / "weights"
    options = ["--checkpoints", tmp_path, "--data", tmp_path / "faces.npz", "--out", out]
    monkeypatch.setattr("sys.argv", ["export", *map(str, options)])
    with pytest.raises(SystemExit, match=r"lips_int8\.pt is older"):
        export.main()
    assert not out.exists()


def test_only_mouths_that_are_held_out_are_measured_each_once(tmp_path):
    empty = np.zeros((2, 2), np.float32)

    def mouth(folder, index, lips=empty):
        return Mouth(folder, index, lips, empty, empty, empty)

    first = np.ones((2, 2), np.float32)
    mouths = [mouth("wild", 1, first), mouth("wild", 1), mouth("wild", 0), mouth("sharp", 0)]
    held = {"wild_validation": np.array([False, True]), "sharp_validation": np.array([True])}
    np.savez(tmp_path / "faces.npz", **held)
    found = evaluate_lip_mask.held_out(mouths, tmp_path / "faces.npz")
    assert {(one.folder, one.index) for one in found} == {("wild", 1), ("sharp", 0)}
    assert len(found) == 2 and any(one.lips is first for one in found)


def test_scenes_without_a_face_are_drawn():
    trials = object.__new__(evaluate_detector.Trials)
    scenes = evaluate_detector.Scenes
    with (
        patch.object(scenes, "_ground", autospec=True, return_value=np.zeros((8, 8, 3))),
        patch.object(scenes, "_decoys", autospec=True) as draw,  # refuses a call with others
    ):
        _, faces = trials.decoys()
    assert draw.call_count == 1 and faces.shape == (0, 4)
