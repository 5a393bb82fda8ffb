"""Training of the net that reads how lipstick shines and fades: drawn truth, and varied mouths."""

from argparse import Namespace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Layer, product
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.reference.read_lipstick import MOUTH_PX, MOUTH_WH, mouth_input
from makeup_video.training.worn.mouth import NUMBERS, contours_of
from makeup_video.training.worn.mouth_crops import (
    draw_lipstick,
    labelled_lipsticks,
    mouth_of,
    target_of,
)
from makeup_video.training.worn.packed import save_crops
from makeup_video.training.worn.vary_mouths import highlights, varied
from packed_crops import numbers_shown
from people import portrait
from reference_photos import face


def mouth(gloss=0.5, fade=0.0):
    return mouth_of(portrait(), face(), (gloss, fade))


@given(seed=st.integers(0, 2**32 - 1))
def test_drawn_lipsticks_have_dials_in_range_and_a_target(seed):
    lipstick = draw_lipstick(np.random.default_rng(seed), ["#B4002E"])
    gradient = next(dial for dial in KINDS["lipstick"].dials if dial.name == "gradient")
    assert gradient.low <= lipstick.whole_shape["gradient"] <= gradient.high
    assert all(0 <= number <= 3 for number in target_of(lipstick))


def test_glossier_and_fading_lipstick_has_a_larger_target():
    worn = product((180, 0, 40), "matte", "lips")
    glossy = product((180, 0, 40), "gloss", "lips")
    plain = target_of(Layer("lipstick", worn))
    assert target_of(Layer("lipstick", glossy))[0] > plain[0] + 1
    assert target_of(Layer("lipstick", worn, {"gradient": 0.9}))[1] > plain[1] + 1


@given(seed=st.integers(0, 2**32 - 1))
def test_varied_mouths_stay_pictures_and_keep_their_fade(seed):
    given_ = mouth(fade=1.25)
    seen, target = varied(given_, np.random.default_rng(seed))
    assert seen.shape == (*MOUTH_WH[::-1], 3) and seen.dtype == np.uint8 and seen.std() > 1
    assert target.dtype == np.float32 and target[0] >= 0.5 and target[1] == 1.25
    assert (seen == varied(given_, np.random.default_rng(seed))[0]).all()


def test_glossy_lips_keep_their_own_highlights():
    given_, rng = mouth(gloss=2.5, fade=1.0), np.random.default_rng(0)
    assert all((varied(given_, rng)[1] == given_.target).all() for _ in range(20))


@given(seed=st.integers(0, 2**32 - 1), wet=st.floats(0, 1))
def test_highlights_lie_on_the_lips(seed, wet):
    contours = contours_of(face())
    contours[2:, :, 1] += 12  # an open mouth
    share = highlights(contours, wet, np.random.default_rng(seed))
    assert share.shape == MOUTH_WH[::-1] and share.dtype == np.float32
    assert share.min() >= 0 and share.max() <= 1
    lips = np.zeros(share.shape, np.uint8)
    for outer, inner in (contours[:2], contours[2:]):
        around = np.concatenate([outer, inner[::-1]])
        cv2.fillPoly(lips, [np.rint(around).astype(np.int32)], 1)
    near = cv2.dilate(lips, np.ones((7, 7), np.uint8))
    assert share[near == 0].max() < 0.05


def test_wetter_lips_have_brighter_highlights():
    contours, brightest = contours_of(face()), []
    for wet in (0.0, 0.5, 1.0):
        drawn = [highlights(contours, wet, np.random.default_rng(seed)) for seed in range(30)]
        brightest.append(np.mean([one.max() for one in drawn]))
    assert brightest == sorted(brightest) and brightest[2] > brightest[0] + 0.3


def test_contours_run_from_corner_to_corner():
    contours = contours_of(face())
    assert contours.shape == (4, 11, 2) and contours.dtype == np.float32
    for outer in contours[::2]:
        wide = np.linalg.norm(outer[0] - outer[-1])
        assert wide == pytest.approx(MOUTH_PX, abs=0.5)
    upper, upper_inner, lower, lower_inner = contours[:, 5, 1]
    assert upper < upper_inner <= lower_inner < lower


def test_labels_of_lipsticks_are_words_of_people():
    labels = np.array(list(labelled_lipsticks().values()))
    assert len(labels) > 900 and labels.max() <= 3
    assert labels.min() == 0 and labels[:, 0].min() <= 0.5
    assert (labels[:, 0] >= 2).sum() > 40 and (labels[:, 1] >= 1).sum() > 100


def packed(path, count=100, real=40, of_each=1):
    """Mouths whose first value is their number; the last ones are real.

    of_each: how many painted mouths show the same face.
    """
    numbered = [np.full((*MOUTH_WH[::-1], 3), number, np.uint8) for number in range(count)]
    is_real = np.arange(count) >= count - real
    np.savez(
        path, rgb8=np.stack(numbered), target=np.zeros((count, 2), np.float32),
        contours=np.zeros((count, 4, 11, 2), np.float32), is_real=is_real,
        face=np.where(is_real, -1, np.arange(count) // of_each),
    )  # fmt: skip


@pytest.mark.parametrize("real", [0, 40])
def test_batches_hold_their_share_and_none_that_are_held_out(tmp_path, real, monkeypatch):
    pytest.importorskip("torch")
    from makeup_video.training.worn import train_lipstick

    monkeypatch.setattr(train_lipstick, "varied", lambda one, rng: (one.rgb8, one.target))
    packed(tmp_path / "data.npz", real=real)
    mouths = train_lipstick.Mouths(tmp_path / "data.npz")
    share = 1 - mouths.painted_share if real else 0
    assert (numbers_shown(mouths) >= 100 - real).mean() == pytest.approx(share, abs=0.04)


def test_all_mouths_of_a_face_are_held_out_together(tmp_path):
    pytest.importorskip("torch")
    from makeup_video.training.worn import train_lipstick

    packed(tmp_path / "data.npz", of_each=7)  # 60 painted: the last tenth begins within a face
    held_out = train_lipstick.Mouths(tmp_path / "data.npz").held_out.rgb8[:, 0, 0, 0]
    assert held_out.tolist() == list(range(49, 60))


def test_a_file_without_painted_mouths_is_refused(tmp_path):
    pytest.importorskip("torch")
    from makeup_video.training.worn import train_lipstick

    packed(tmp_path / "data.npz", real=100)
    with pytest.raises(SystemExit, match=r"data.npz has no painted crops .* pack it with"):
        train_lipstick.Mouths(tmp_path / "data.npz")


def test_glossy_and_fading_mouths_are_shown_more_often(tmp_path):
    pytest.importorskip("torch")
    from makeup_video.training.worn import train_lipstick

    packed(tmp_path / "data.npz")
    often = train_lipstick.Mouths(tmp_path / "data.npz").how_often
    plain, glossy, fading, both = often(np.array([(1, 0), (2, 0), (1, 1.5), (2, 1.5)]))
    assert plain < glossy < both and plain < fading < both


def test_packed_mouths_are_read_again(tmp_path):
    pytest.importorskip("torch")
    from makeup_video.training.worn import train_lipstick

    painted = [mouth_of(portrait(), face(), (number, 0.0)) for number in range(10)]
    save_crops(tmp_path / "new" / "data.npz", painted, [mouth()], range(10))
    held_out = train_lipstick.Mouths(tmp_path / "new" / "data.npz").held_out
    assert held_out.target.tolist() == [[9.0, 0.0]]
    assert (held_out.rgb8[0] == mouth().rgb8).all()
    assert (held_out.contours[0] == mouth().contours).all()


def test_training_writes_a_net_that_answers_as_in_torch(tmp_path, capsys):
    torch = pytest.importorskip("torch")
    pytest.importorskip("onnx")
    import onnxruntime
    from makeup_video.training.worn import train_lipstick

    packed(tmp_path / "data.npz")
    files = {"data": tmp_path / "data.npz", "out": tmp_path / "net.onnx"}
    options = Namespace(**files, steps=1, threads=2)
    train_lipstick.train(options)
    said = capsys.readouterr().out
    assert "step 1, " in said and all(f"{name} " in said for name in NUMBERS)
    files["out"].unlink()
    train_lipstick.train(options)  # exports a finished run again
    inputs = np.stack([mouth_input(portrait(), face())] * 2)
    session = onnxruntime.InferenceSession(str(files["out"]))
    assert session.run(None, {"rgb8": inputs})[0].shape == (2, 2)
    net = train_lipstick.make_net().eval()
    with torch.no_grad():
        own = net(torch.from_numpy(inputs)).numpy()
    train_lipstick.export(net, tmp_path / "own.onnx")
    session = onnxruntime.InferenceSession(str(tmp_path / "own.onnx"))
    assert session.run(None, {"rgb8": inputs})[0] == pytest.approx(own, abs=1e-4)
    assert Net("reference_lipstick")(inputs)["lipstick"].shape == own.shape
