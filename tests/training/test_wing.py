"""Training of the net that reads wings: drawn truth, varied corners, and the shipped net."""

from argparse import Namespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Layer, Look, product
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.reference.wing import ANGLE_UNIT, CORNER_WH, corner_inputs
from makeup_video.training.worn.draw_looks import draw_look
from makeup_video.training.worn.wing_crops import SHARES, target_of, varied
from people import portrait
from reference_photos import face


def liner(strength=1.0, **shape):
    worn = product((10, 10, 10), "matte", "liner")
    return Look([Layer("eyeliner", worn, shape, strength)])


def test_the_target_of_a_look_is_its_wing():
    assert target_of(Look()) == (0, 0, 0, 0)
    assert target_of(liner()) == (1, 0, 0, pytest.approx(30 / ANGLE_UNIT))
    winged = target_of(liner(wing=0.4, wing_angle=15.0))
    assert winged == pytest.approx((1, 1, 0.4, 15 / ANGLE_UNIT))


def test_a_liner_too_sheer_to_see_is_no_target():
    assert target_of(liner(strength=0.2, wing=0.4)) == (0, 0, 0, 0)


@given(seed=st.integers(0, 2**32 - 1))
def test_varied_corners_stay_pictures_of_the_same_size(seed):
    corner = corner_inputs(portrait(), face())[0][0]
    seen = varied(corner, np.random.default_rng(seed))
    assert seen.shape == (*CORNER_WH[::-1], 3) and seen.dtype == np.uint8
    assert seen.std() > 1
    assert (seen == varied(corner, np.random.default_rng(seed))).all()


def test_drawn_looks_wear_the_kinds_that_were_asked_for():
    rng = np.random.default_rng(1)
    kinds = {layer.kind for _ in range(40) for layer in draw_look(rng, {}, SHARES).layers}
    assert kinds == set(SHARES)


def test_a_resumed_run_draws_other_examples(tmp_path, monkeypatch):
    pytest.importorskip("torch")
    pytest.importorskip("onnx")
    from makeup_video.training.worn import train_wing

    drawn = []

    def noted(rgb8, rng):
        drawn.append((int(rgb8[0, 0, 0]), rng.random(), float(train_wing.torch.rand(()))))
        return rgb8

    monkeypatch.setattr(train_wing, "varied", noted)
    numbered = [np.full((*CORNER_WH[::-1], 3), number, np.uint8) for number in range(100)]
    targets = np.float32([target_of(liner(wing=0.4)), target_of(Look())] * 50)
    np.savez(tmp_path / "data.npz", inputs=np.stack(numbered), targets=targets)
    for steps in (1, 2):
        files = {"data": tmp_path / "data.npz", "out": tmp_path / "net.onnx"}
        train_wing.train(Namespace(**files, steps=steps, threads=2))
    assert len(drawn) == 2 * train_wing.BATCH
    first, second = (zip(*half, strict=True) for half in np.split(np.array(drawn), 2))
    assert all(one != other for one, other in zip(first, second, strict=True))


def test_the_shipped_net_is_one_that_this_training_exports(tmp_path):
    torch = pytest.importorskip("torch")
    pytest.importorskip("onnx")
    from makeup_video.training.worn.train_wing import WingNet, export, loss_of, report

    inputs = corner_inputs(portrait(), face())[0]
    net = WingNet().eval()
    export(net, tmp_path / "wing.onnx")
    import onnxruntime

    session = onnxruntime.InferenceSession(str(tmp_path / "wing.onnx"))
    found = session.run(None, {"rgb8": inputs})[0]
    net.eval()
    with torch.no_grad():
        assert found == pytest.approx(net(torch.from_numpy(inputs)).numpy(), abs=1e-4)
    assert Net("reference_wing")(inputs)["wing"].shape == found.shape
    targets = np.float32([target_of(liner(wing=0.4)), target_of(Look())])
    loss = loss_of(net.all_numbers(torch.from_numpy(inputs)), torch.from_numpy(targets))
    assert float(loss) > 0
    assert "area under curve" in report(net, inputs, targets)
