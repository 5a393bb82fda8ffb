"""Where the lip net has lipstick: what follows from mouth, opening and teeth, and from the crop."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

model = pytest.importorskip("makeup_video.training.faces.model", reason="needs PyTorch")
torch = model.torch
LIP, OPENING, TOOTH, NO_TOOTH = 4.0, 9.0, 4.0, -4.0
LIPS_LIGHT, DARK = 0.4, -0.8  # in the crop, -1 to 1
DOUBT = st.floats(-model.MARGIN + 0.01, -model.DOUBT_MARGIN - 0.01)


def lipstick(mouth, opening, teeth, brightness=LIPS_LIGHT):
    """Log-odds of lipstick, (H, W), from arrays of that shape or numbers."""
    numbers = map(torch.as_tensor, (mouth, opening, teeth, brightness))
    *planes, grey = torch.broadcast_tensors(*numbers)
    cells = torch.nn.functional.pixel_unshuffle(torch.stack(planes)[None].float(), 2)
    return model.lipstick_logits(cells, grey.float().expand(1, 3, *grey.shape))[0]


def painted(opening: list[float], teeth: float, brightness: list[float]) -> list[bool]:
    """Which px are painted, down through a mouth. opening: log-odds of an even number of px."""
    columns = [torch.tensor(column)[:, None].repeat(1, 4) for column in (opening, brightness)]
    return (lipstick(LIP, columns[0], teeth, columns[1])[:, 1] > 0).tolist()


@given(st.floats(-9, 9))
def test_lipstick_goes_on_the_mouth_but_not_on_its_opening(teeth):
    for mouth, opening in ((3.0, -6.0), (3.0, 6.0), (-3.0, -6.0)):
        found = lipstick(torch.full((4, 6), mouth), opening, teeth)
        assert ((found > 0) == (mouth > 0 > opening)).all()


@given(DOUBT)
def test_doubt_is_decided_for_light_lips_and_not_for_teeth(doubt):
    opening = [-LIP] * 3 + [doubt] * 12 + [OPENING] * 9
    light = [LIPS_LIGHT] * 15 + [DARK] * 9
    assert painted(opening, NO_TOOTH, light) == [True] * 15 + [False] * 9
    assert painted(opening, TOOTH, light) == [True] * 3 + [False] * 21


@given(DOUBT)
def test_a_doubtful_tongue_in_the_shade_is_not_painted(doubt):
    broad = 2 * model.NEAR_PX + 2
    opening = [OPENING] * 10 + [doubt] * broad + [-LIP] * 10
    shaded = [DARK] * (10 + broad) + [LIPS_LIGHT] * 10
    found = painted(opening, NO_TOOTH, shaded)[10:]
    assert found[broad:] == [True] * 10
    assert not any(found[broad - model.NEAR_PX : broad])


@given(DOUBT, st.integers(1, model.NEAR_PX))
def test_the_dark_line_between_shut_lips_is_painted(doubt, half):
    opening = [-LIP] * 10 + [doubt] * 2 * half + [-LIP] * 10
    line = [LIPS_LIGHT] * 10 + [DARK] * 2 * half + [LIPS_LIGHT] * 10
    assert all(painted(opening, NO_TOOTH, line))
    assert sum(painted(opening, TOOTH, line)) == 20


@given(st.lists(st.tuples(*[st.floats(-20, 20)] * 3), min_size=4, max_size=4), st.floats(0, 9))
def test_likelier_teeth_bring_less_lipstick(pixels, more):
    mouth, opening, teeth = torch.tensor(pixels).T.reshape(3, 2, 2)
    likelier = lipstick(mouth, opening, teeth + more)
    assert (likelier <= lipstick(mouth, opening, teeth) + 1e-4).all()


def test_px_of_cells_are_means_of_three_columns():
    """Values that alternate from column to column cancel out: they would paint a comb."""
    torch.manual_seed(1)
    paint, features = model.PaintCells(5, 12), torch.randn(2, 5, 4, 6)
    alone = torch.nn.functional.conv2d(features, paint.weight, paint.bias)
    rows = torch.nn.functional.pixel_shuffle(alone, 2)
    wanted = (rows[..., :-2] + 2 * rows[..., 1:-1] + rows[..., 2:]) / 4
    found = torch.nn.functional.pixel_shuffle(paint(features), 2)[..., 1:-1]
    assert torch.allclose(found, wanted, atol=1e-5)


def test_weights_of_px_come_back_from_those_that_are_shipped():
    torch.manual_seed(1)
    paint, features = model.PaintCells(5, 12), torch.randn(2, 5, 4, 6)
    conv = paint.as_conv()
    assert conv.weight.shape == (12, 5, 1, 3)
    assert torch.allclose(conv(features), paint(features), atol=1e-6)
    assert torch.allclose(model.weight_of_px(conv.weight), paint.weight, atol=1e-6)


def test_an_exported_lip_net_can_be_trained_further(tmp_path):
    from makeup_video.training.faces import export, from_onnx

    torch.manual_seed(1)
    sizes = (32, 16), (8, 16, 16, 16), (0, 1, 1, 1), torch.zeros(5, 3), torch.ones(4, 15)
    net, path = model.LipNet(*sizes).eval(), tmp_path / "lips.onnx"
    for values in net.parameters():  # the exporter would merge equal parameters
        torch.nn.init.normal_(values, 0, 0.1)
    weight = net.paint[0].weight.clone()
    rgb8 = torch.randint(0, 256, (2, 16, 32, 3), dtype=torch.uint8)
    outputs = export.OUTPUTS["lips"]
    axes = {key: {0: "n"} for key in ("rgb8", *outputs)}
    export.to_onnx(export.Exported(export.folded(net), outputs), path, rgb8.numpy(), outputs, axes)
    again = model.LipNet(*sizes)
    from_onnx.restore(again, path, model.normalise(rgb8))
    assert torch.allclose(again.paint[0].weight, weight, atol=1e-3)
