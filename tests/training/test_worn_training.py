"""Training of the net that reads what is worn: folds, teachers, and the shipped net."""

from argparse import Namespace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.reference.makeup_input import INPUT_WH, makeup_input
from makeup_video.pipeline.reference.makeup_numbers import COUNT
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.training.worn.prepare import LABELS, rows_without_labels
from makeup_video.training.worn.scores import UNKNOWN
from people import portrait
from reference_photos import face

pytest.importorskip("torch")
from makeup_video.training.worn import train

SOURCES = st.lists(st.tuples(st.integers(0, 2), st.booleans()), min_size=12, max_size=60)


@given(SOURCES, st.integers(2, 6))
def test_every_face_is_held_out_in_one_fold(drawn, folds):
    sources, real = np.array([source for source, _ in drawn]), np.array([real for _, real in drawn])
    real[0] = True
    held = [train.split(sources, real, folds, fold) for fold in range(folds)]
    assert (np.sum(held, 0) == 1).all()
    person = np.cumsum(real)
    for fold in held:  # paint is held out with its bare face, if both are of one source
        for at in np.flatnonzero(fold[1:] & fold[:-1] & ~real[1:]):
            assert person[at] == person[at + 1]


def test_teachers_tell_of_faces_that_they_did_not_see():
    count, folds = 40, 4
    real = np.arange(count) % 2 == 0
    labels = np.where(np.arange(count)[:, None] < 32, 1, UNKNOWN) * np.ones((1, 4), int)
    data = {"labels": labels, "sources": np.arange(count) // 20, "real": real}
    odds = [np.full((count, 4), 10.0 * fold) for fold in range(folds)]
    taught = train.teachers_of(odds, data)
    for fold in range(folds):
        held = train.split(data["sources"], real, folds, fold) & (np.arange(count) < 32)
        assert (taught[held] == 10 * fold).all()
    assert (taught[32:] == np.mean([10 * fold for fold in range(folds)])).all()


@given(st.lists(st.sampled_from([0, 1, UNKNOWN]), min_size=1), st.floats(-20, 20))
def test_targets_lie_between_label_and_teacher(labels, told):
    column = np.array(labels)[:, None]
    alone, known = train.targets_of(column, None)
    assert (known == (column != UNKNOWN)).all()
    both, all_known = train.targets_of(column, np.full(column.shape, told))
    share = 1 / (1 + np.exp(-told))
    assert all_known.all()
    low, high = np.minimum(alone, share) - 1e-6, np.maximum(alone, share) + 1e-6
    assert ((both >= low) & (both <= high))[known].all()
    assert np.allclose(both[~known], share, atol=1e-6)


def options_for(folder, inputs, **chosen):
    """Options of a training in two steps, whose data are in the folder."""
    count = len(inputs)
    np.savez(
        folder / "data.npz",
        inputs=inputs,
        labels=np.tile(np.uint8([[0, 1, UNKNOWN, 0]]), (count, 1)),
        vectors=np.zeros((count, COUNT), np.float32),
        weights=np.ones((count, COUNT), np.float32),
        sources=np.zeros(count, np.uint8),
        real=np.arange(count) % 2 == 0,
    )
    usual = Namespace(
        data=[folder / "data.npz"], out=folder / "net.onnx", size="small", steps=2, batch=8,
        report=1, folds=2, fold=1, teachers=[], older=None, seed=0, device="cpu", threads=2,
    )  # fmt: skip
    return Namespace(**{**vars(usual), **chosen})


def test_a_resumed_run_draws_other_examples(tmp_path, monkeypatch):
    pytest.importorskip("onnx")
    drawn, rolled = [], []

    def noted(rgb8):
        drawn.append(rgb8[:, 0, 0, 0].tolist())
        rolled.append(float(train.torch.rand(())))
        return rgb8

    monkeypatch.setattr(train, "varied", noted)
    numbered = [np.full((*INPUT_WH[::-1], 3), number, np.uint8) for number in range(40)]
    for steps in (1, 2):
        train.train(options_for(tmp_path, np.stack(numbered), steps=steps))
    assert len(drawn) == 2 and drawn[0] != drawn[1] and rolled[0] != rolled[1]


def test_the_shipped_net_is_one_that_this_training_exports(tmp_path):
    pytest.importorskip("onnx")
    seen = makeup_input(portrait(), face(), photo_light(portrait(), face()))
    count = 40
    options = options_for(tmp_path, np.stack([seen] * count))
    train.train(options)
    odds = np.load(tmp_path / "net.npy")
    assert odds.shape == (count, 4) and np.isfinite(odds).all()
    taught = Namespace(**{**vars(options), "teachers": [tmp_path / "net.npy"] * 2})
    taught.out, taught.older = tmp_path / "taught.onnx", tmp_path / "net.onnx"
    train.train(taught)
    import onnxruntime

    ours = onnxruntime.InferenceSession(str(tmp_path / "taught.onnx")).run(
        None, {"rgb8": seen[None]}
    )
    shipped = Net("reference_makeup")(seen[None])
    assert [part.shape for part in ours] == [part.shape for part in shipped.values()]


@pytest.mark.parametrize("seed", range(3))
def test_varied_pictures_stay_pictures(seed):
    import torch

    torch.manual_seed(seed)
    seen = makeup_input(portrait(), face(), photo_light(portrait(), face()))
    given_ = torch.from_numpy(np.stack([seen] * (train.ALIKE + 1)))
    made = train.varied(given_)
    assert made.shape == given_.shape and made.dtype == torch.uint8
    assert float((made.float() - given_.float()).abs().mean()) > 3


def test_pictures_without_labels_are_those_that_no_row_names(tmp_path):
    for name in ("a.jpg", "b.jpg", "c.jpg"):
        cv2.imwrite(str(tmp_path / name), np.zeros((4, 4, 3), np.uint8))
    unknown = [UNKNOWN] * len(LABELS)
    everything = [(tmp_path / name, unknown) for name in ("a.jpg", "b.jpg", "c.jpg")]
    assert list(rows_without_labels(tmp_path)) == everything
    (tmp_path / "worn.csv").write_text("name,lips,shadow,liner,blush,flags\nb.jpg,0,0,0,0,x\n")
    assert list(rows_without_labels(tmp_path)) == [everything[0], everything[2]]
