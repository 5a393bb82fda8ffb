"""Makes a checkpoint of a shipped float net, so that training can go on from it.

    python -m makeup_video.training.faces.from_onnx pipeline/weights/lips.onnx \\
        --out runs/lips_first.pt

The shipped file holds convolutions with their normalisation folded in. The normalisation is put
back with the mean and the variance that the convolutions have on training crops.
"""

import argparse
from pathlib import Path

import numpy as np
import onnx
import torch
from makeup_video.training.faces.checkpoint import Checkpoint
from makeup_video.training.faces.crops import SPECS
from makeup_video.training.faces.export import examples
from makeup_video.training.faces.model import Conv, build, normalise
from onnx import numpy_helper
from torch import Tensor, nn

CROPS = 512  # from which means and variances are computed


def folded_weights(path: Path) -> list[tuple[Tensor, Tensor]]:
    """Weight and bias of a float net's learned convolutions, in the order in which they run."""
    graph = onnx.load(path).graph
    values = {t.name.removesuffix("_half"): numpy_helper.to_array(t) for t in graph.initializer}

    def tensor(name: str) -> Tensor:
        return torch.from_numpy(values[name.removesuffix("_half")].astype(np.float32))

    convs = (node for node in graph.node if node.op_type == "Conv")
    return [(tensor(node.input[1]), tensor(node.input[2])) for node in convs]


def other_weights(path: Path, net: nn.Module) -> dict[str, Tensor]:
    """The parameters that the file keeps under the names of the net itself, and the mean points."""
    graph, state, found = onnx.load(path).graph, net.state_dict(), {}
    mean = next(n.input[2] for n in graph.node if n.output[0].endswith("points/Gemm_output_0"))
    for tensor in graph.initializer:
        name = tensor.name.removesuffix("_half").removeprefix("net.")
        if tensor.name == mean:  # laid flat, under a number
            name = "points.mean"
        if name in state:
            values = torch.from_numpy(numpy_helper.to_array(tensor).astype(np.float32))
            found[name] = values.view(state[name].shape)
    return found


@torch.no_grad()
def restore(net: nn.Module, path: Path, crops: Tensor) -> None:
    """Fill the net, in place, so that it computes what the file does, in training as well."""
    net.load_state_dict(other_weights(path, net), strict=False)
    convs = [part for part in net.modules() if isinstance(part, Conv)]
    seen: list[Conv] = []
    hooks = [part.register_forward_hook(lambda part, *_: seen.append(part)) for part in convs]
    net.eval()(crops[:1])
    for hook in hooks:
        hook.remove()
    folded = [pair for pair in folded_weights(path) if pair[0].shape[-1] == 3]
    for part, (weight, bias) in zip(seen, folded, strict=True):
        conv, norm = part[0], part[1]
        conv.weight.copy_(weight)
        norm.reset_parameters()
        norm.running_var.fill_(1 - norm.eps)
        norm.bias.copy_(bias)
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
    parser.add_argument("weights", type=Path)
    parser.add_argument("--data", type=Path, default=Path("runs/faces.npz"))
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    name = options.weights.stem
    spec = SPECS[name]
    net = build(name, spec.size_wh, torch.zeros(200, len(spec.points), 3))
    crops = torch.from_numpy(examples(name, options.data, CROPS))
    restore(net, options.weights, normalise(crops))
    optimizer = torch.optim.AdamW(net.parameters())
    Checkpoint(options.out, net, optimizer, 0.999).save((name, len(spec.points)))


if __name__ == "__main__":
    main()
