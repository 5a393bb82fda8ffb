"""Painted lips are scored by where paint is missing and where it does not belong."""

import cv2
import numpy as np
import pytest
from makeup_video.training.faces.evaluate_painted_lips import (
    INTERIOR,
    LIPS,
    is_open,
    main,
    painted_lips,
    score,
)

IOD = 100.0


def labels(half_gap: int) -> np.ndarray:
    drawn = np.zeros((100, 140), np.uint8)
    cv2.ellipse(drawn, (70, 50), (45, 25), 0, 0, 360, LIPS, -1)
    if half_gap:
        cv2.ellipse(drawn, (70, 50), (35, half_gap), 0, 0, 360, INTERIOR, -1)
    return drawn


@pytest.mark.parametrize("half_gap", [0, 6, 15])
def test_exact_paint_has_no_faults(half_gap):
    drawn = labels(half_gap)
    found = score(drawn == LIPS, drawn, IOD)
    assert (found.iou, found.corners, found.interior, found.outside) == (1, 1, 0, 0)
    assert is_open(drawn) == (half_gap > 0)
    if half_gap:
        assert (found.beside, found.missed) == (1, 0)
    else:
        assert np.isnan([found.beside, found.missed]).all()


def test_a_bare_ring_is_missed_and_painted_teeth_are_interior():
    drawn = labels(15)
    ring = cv2.dilate((drawn == INTERIOR).astype(np.uint8), np.ones((5, 5))) > 0
    bare = score((drawn == LIPS) & ~ring, drawn, IOD)
    assert bare.beside < 0.6
    assert bare.missed > 0.05
    assert bare.interior == bare.outside == 0
    over = score(drawn > 0, drawn, IOD)
    assert over.beside == 1
    assert over.interior == pytest.approx((drawn == INTERIOR).sum() / (drawn == LIPS).sum())


def test_a_folder_of_shut_mouths_is_measured(tmp_path, monkeypatch, capsys):
    cv2.imwrite(str(tmp_path / "a.png"), labels(0))
    cv2.imwrite(str(tmp_path / "a.jpg"), np.zeros((100, 140, 3), np.uint8))  # nobody is found
    monkeypatch.setattr("sys.argv", ["evaluate_painted_lips", "--masks", str(tmp_path)])
    main()
    first, second = capsys.readouterr().out.splitlines()
    assert first == "open (0)" and second.startswith("shut (1): iou 0.000")


def test_paint_on_skin_is_outside_and_no_face_is_no_paint():
    drawn = labels(0)
    wide = cv2.dilate(drawn, np.ones((9, 9))) > 0
    assert score(wide, drawn, IOD).outside > 0.2
    assert score(painted_lips(None, drawn.shape), drawn, IOD).iou == 0
