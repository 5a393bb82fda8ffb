"""The reference net: its initial state, its error and its training."""

import pytest
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.reference.crops import CROPPED
from makeup_video.training.reference.fixed_crops import fixed_crops


def test_the_net_begins_at_the_mean_and_has_the_lite_sizes():
    torch = pytest.importorskip("torch")
    from makeup_video.training.reference.model import ReferenceNet

    mean = torch.linspace(0.1, 0.9, 7)
    # the published 4.65 and 13.0 million parameters, without their 1280 x 1000 classifiers; the
    # head of this net has 8 x 6 colours as further inputs
    for size, blocks, millions in (("lite0", 16, 3.38), ("lite4", 30, 11.73)):
        torch.manual_seed(0)
        net = ReferenceNet(size, mean, "lips", shrink=2)
        assert len(net.blocks) == blocks
        assert sum(p.numel() for p in net.parameters()) / 1e6 == pytest.approx(millions, abs=0.015)
        with torch.no_grad():
            output = net(torch.rand(8, 3, 96, 128) * 2 - 1)
        assert output.shape == (8, 7) and (output - mean).abs().mean() < 0.1


def test_a_sheer_looks_colour_hardly_counts_in_its_error():
    torch = pytest.importorskip("torch")
    from makeup_video.training.reference.train import error_of

    true = torch.tensor([[0.8, 0.7, 0.1, 0.2, 0.5, 0.5, 0.1], [0.02, 0.7, 0.1, 0.2, 0, 0.5, 0]])
    bluer = true + torch.tensor([0, 0, 0, 0.2, 0, 0, 0])
    thick, sheer = (error_of(bluer[i : i + 1], true[i : i + 1]) for i in (0, 1))
    assert thick > 5 * sheer > 0 and error_of(true, true) == 0


def test_an_output_below_zero_for_every_crop_still_learns():
    torch = pytest.importorskip("torch")
    from makeup_video.training.reference.model import ReferenceNet

    net = ReferenceNet("lite0", torch.full((7,), -1.0), "lips", shrink=2).train()
    net(torch.rand(2, 3, 96, 128)).sum().backward()
    assert (net.head.bias.grad > 0).all() and (net.eval()(torch.rand(1, 3, 96, 128)) == 0).all()


def test_dense_layers_are_trained_before_the_convolutions():
    torch = pytest.importorskip("torch")
    from makeup_video.training.reference.model import ReferenceNet
    from makeup_video.training.reference.train_head import mirrored, train_layers

    torch.manual_seed(0)
    net = ReferenceNet("lite0", torch.full((7,), 0.5), "eyes", shrink=2).eval()
    crops = torch.rand(256, 3, 64, 160) * 2 - 1
    squares = net.squares(crops)
    turned = mirrored(squares, "eyes", net.square)
    assert torch.allclose(turned, net.squares(crops.flip(3)), atol=1e-5)
    targets = 0.5 + 0.25 * crops.mean((1, 2, 3))[:, None].expand(-1, 7) * 20
    before = (net(crops[:16]) - targets[:16]).square().mean()
    train_layers(net, squares, targets, "eyes", epochs=8)
    taught = net.eval()(crops[:16])
    assert (taught - targets[:16]).square().mean() < before
    assert torch.allclose(taught, torch.relu(net.head(torch.cat(
        [torch.zeros(16, 1280), net.colours(squares[:16])], 1))), atol=1e-6)  # fmt: skip


def test_training_goes_on_from_a_shipped_reference_net():
    torch = pytest.importorskip("torch")
    from makeup_video.training.reference.from_onnx import WEIGHTS, restored
    from makeup_video.training.reference.model import ReferenceNet
    from makeup_video.training.reference.train import inputs

    for region in CROPPED:
        crops = inputs(torch.from_numpy(fixed_crops(region)))
        net = ReferenceNet("lite0", torch.ones(7), region, shrink=2)
        restored(WEIGHTS / f"reference_{region}.onnx", net, crops)
        shipped = torch.tensor(Net(f"reference_{region}")(fixed_crops(region))["targets"])
        with torch.no_grad():
            assert (net.eval()(crops) - shipped).abs().max() < 5e-3
            net.train().drop.eval()
            assert (torch.relu(net(crops)) - shipped).abs().max() < 5e-3
