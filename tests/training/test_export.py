"""Exports, and what is measured of nets: nothing old is written, nothing learned is measured."""

import os
from unittest.mock import patch

import numpy as np
import pytest

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
        patch.object(scenes, "_decoys", autospec=True) as draw,  # refuses other parameters
    ):
        _, faces = trials.decoys()
    assert draw.call_count == 1 and faces.shape == (0, 4)
