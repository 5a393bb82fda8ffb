"""Makes a checkpoint of a shipped net, so that training can go on from it.

    python -m makeup_video.training.faces.from_onnx pipeline/weights/lips.onnx \\
        --out runs/lips_first.pt

The shipped file holds convolutions with their normalisation folded in. The normalisation is put
back with the mean and the variance that the convolutions' outputs have on training crops. The
weights of an integer net come back as they were rounded, with 7 bits.
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np
import onnx
import torch
from makeup_video.training.faces.checkpoint import Checkpoint
from makeup_video.training.faces.crops import SPECS
from makeup_video.training.faces.export import examples
from makeup_video.training.faces.export_int8 import SPAN
from makeup_video.training.faces.model import Conv, PaintCells, build, normalise, weight_of_px
from makeup_video.training.faces.train_detector import Detector
from makeup_video.training.inputs import existing, made_by
from onnx import numpy_helper
from torch import Tensor, nn

CROPS, SCENES = 512, 64  # numbers of pictures from which means and variances are computed


class Layer(NamedTuple):
    """A convolution, or the layer of the shape coefficients: its node, and what it learned."""

    node: str
    weight: Tensor
    bias: Tensor


def plain(name: str) -> str:
    """The name that a tensor had before export.py stored it in half precision."""
    return name.removesuffix("_half")


def layers(path: Path) -> list[Layer]:
    """The layers of a file in the order in which they run; integers as the numbers they mean."""
    graph = onnx.load(path).graph
    values = {plain(t.name): numpy_helper.to_array(t) for t in graph.initializer}
    found = []
    for node in graph.node:
        names = [plain(name) for name in node.input]
        if node.op_type in ("QLinearConv", "QGemm"):
            codes, steps = values[names[3]], values[names[4]]
            sums = values[names[8 if node.op_type == "QLinearConv" else 6]]
            weight = codes * steps.reshape(-1, *[1] * (codes.ndim - 1))
            bias = sums * steps * values[names[1]]  # in steps of the weights and of the input
        elif node.op_type in ("Conv", "FusedConv"):
            weight, bias = values[names[1]], values[names[2]]
        else:
            continue
        numbers = (torch.from_numpy(np.array(part, np.float32)) for part in (weight, bias))
        found.append(Layer(node.name, *numbers))
    return found


def unpacked(layer: Layer) -> Layer:
    """The first convolution as it was before export_int8.FirstConv laid it out."""
    count = len(layer.bias) // (SPAN // 2)
    packed = layer.weight[:count].unflatten(1, (SPAN, 3))  # O, px in, C, y, block
    places = [divmod(x - 1 + SPAN, SPAN) for x in range(3)]
    weight = torch.stack([packed[:, px, :, :, block] for block, px in places], -1)
    # That layout takes 128, not 127.5, for the middle of the codes.
    bias = layer.bias[:count] - weight.sum((1, 2, 3)) * (0.5 / 127.5)
    return Layer(layer.node, weight, bias)


def folded_weights(path: Path) -> list[Layer]:
    """A net's 3 x 3 convolutions with their normalisation, in the order in which they run."""
    found = [layer for layer in layers(path) if layer.weight.ndim == 4]
    if found[0].weight.shape[1] == 3 * SPAN:
        found[0] = unpacked(found[0])
    return [layer for layer in found if layer.weight.shape[2:] == (3, 3)]


def other_weights(path: Path, net: nn.Module) -> dict[str, Tensor]:
    """The parameters that the file keeps under the names of the net itself, and the mean points."""
    graph, state, found = onnx.load(path).graph, net.state_dict(), {}
    heads = (node for node in graph.node if node.output[0].endswith("points/Gemm_output_0"))
    means = [plain(head.input[2]) for head in heads]  # flat, named by a number; none of a detector
    for tensor in graph.initializer:
        name = plain(tensor.name)
        name = "points.mean" if name in means else name.removeprefix("net.")
        values = torch.from_numpy(numpy_helper.to_array(tensor).astype(np.float32))
        if name in state and values.numel() == state[name].numel():
            found[name] = values.view(state[name].shape)
    for node, weight, bias in layers(path):
        name = ".".join(node.split("/")[2:-1])
        if f"{name}.weight" in state:
            rows, inputs = state[f"{name}.weight"].shape[:2]  # integer nets have more, which are 0
            if isinstance(net.get_submodule(name), PaintCells):
                weight = weight_of_px(weight)
            found |= {f"{name}.weight": weight[:rows, :inputs], f"{name}.bias": bias[:rows]}
    return found


@torch.no_grad()
def restore(net: nn.Module, path: Path, crops: Tensor) -> None:
    """Fill the net, in place, so that it computes what the file does, even in training mode."""
    net.load_state_dict(other_weights(path, net), strict=False)
    restore_convs(net, Conv, folded_weights(path), crops)


@torch.no_grad()
def restore_convs(
    net: nn.Module, kind: type[nn.Sequential], weights: list[Layer], crops: Tensor
) -> None:
    """Fill the convolutions of a net and their normalisations, in place.

    kind: the class of the modules that begin with a convolution and its normalisation.  weights:
    the convolutions with the normalisation folded in, in the order in which they run.
    """
    convs = [part for part in net.modules() if isinstance(part, kind)]
    seen: list[nn.Sequential] = []
    hooks = [part.register_forward_hook(lambda part, *_: seen.append(part)) for part in convs]
    net.eval()(crops[:1])
    for hook in hooks:
        hook.remove()
    for part, (_, weight, bias) in zip(seen, weights, strict=True):
        conv, norm = part[0], part[1]
        rows, inputs = conv.weight.shape[:2]
        conv.weight.copy_(weight[:rows, :inputs])
        norm.reset_parameters()
        norm.running_var.fill_(1 - norm.eps)
        norm.bias.copy_(bias[:rows])
    moments: dict[nn.Module, tuple[Tensor, Tensor]] = {}

    def watch(conv: nn.Module, _inputs: tuple, out: Tensor) -> None:
        moments[conv] = out.mean((0, 2, 3)), out.var((0, 2, 3), unbiased=False)

    hooks = [part[0].register_forward_hook(watch) for part in seen]
    net(crops)
    for hook in hooks:
        hook.remove()
    for part in seen:
        (mean, variance), norm = moments[part[0]], part[1]
        norm.running_mean.copy_(mean)
        norm.running_var.copy_(variance)
        norm.weight.copy_((variance + norm.eps).sqrt())
        norm.bias.add_(mean)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("weights", type=existing)
    parser.add_argument("--data", type=made_by("faces.prepare"), default="runs/faces.npz")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    name = options.weights.stem
    if name == "detector":
        net: nn.Module = Detector()
        count, crops = 0, examples(name, options.data, SCENES)
    else:
        count, crops = len(SPECS[name].points), examples(name, options.data, CROPS)
        net = build(name, SPECS[name].size_wh, torch.zeros(200, count, 3))
    restore(net, options.weights, normalise(torch.from_numpy(crops)))
    optimizer = torch.optim.AdamW(net.parameters())
    Checkpoint(options.out, net, optimizer, 0.999).save((name, count))


if __name__ == "__main__":
    main()
