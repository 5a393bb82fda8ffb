"""Writes a rounded net as ONNX in integers for ONNX Runtime: QDQ, int8 weights, int32 sums.

The written net has the outputs of the rounded net, but a faster layout. The runtime gathers the
integers of a convolution pixel by pixel, in pieces of 16 bytes at best, so few pixels of many
channels are much cheaper than many pixels of few channels.
"""

from pathlib import Path

import numpy as np
import onnx
import torch
from makeup_video.training.faces.fake_quantise import (
    WEIGHT_STEPS,
    RoundedConv,
    RoundedLinear,
    RoundedWeights,
)
from makeup_video.training.faces.model import LipNet
from onnx import helper, numpy_helper
from torch import Tensor, nn

F = nn.functional
SPAN = 4  # px of a row that are computed as one px
PIECE = 16  # least number of channels between convolutions
CODE, GREY = np.float32(1 / 127.5), np.uint8(128)  # step of the input, and the code that means 0


def unpack(x: Tensor, span: int) -> Tensor:
    """(N, span * C, H, W / span) -> (N, C, H, W): channels become neighbouring px of a row."""
    n, c, h, w = (int(side) for side in x.shape)
    return x.permute(0, 2, 3, 1).reshape(n, h, w * span, c // span).permute(0, 3, 1, 2)


class PlainConv(nn.Module):
    """A convolution whose weights already are multiples of their steps."""

    def __init__(self, conv: RoundedConv, outputs: int) -> None:
        """outputs: their number; added ones are 0. Inputs, but for R, G, B, are padded to PIECE."""
        super().__init__()
        weight, bias = conv.rounded().detach(), conv.bias.detach()
        rows, inputs, *size = weight.shape
        wide = torch.zeros(outputs, inputs if inputs == 3 else max(inputs, PIECE), *size)
        wide[:rows, :inputs] = weight
        self.weight, self.bias = nn.Parameter(wide), nn.Parameter(F.pad(bias, (0, outputs - rows)))
        self.stride, self.padding, self.relu = conv.stride, conv.padding, conv.relu
        self.round = conv.round

    def forward(self, x: Tensor) -> Tensor:
        x = F.conv2d(x, self.weight, self.bias, self.stride, self.padding)
        return self.round(torch.relu(x) if self.relu else x)


class PlainLinear(nn.Module):
    """A linear layer whose weights already are multiples of their steps."""

    def __init__(self, linear: RoundedLinear) -> None:
        super().__init__()
        self.weight, self.bias = nn.Parameter(linear.rounded().detach()), linear.bias

    def forward(self, x: Tensor) -> Tensor:
        return F.linear(x, self.weight, self.bias)


class FirstConv(nn.Module):
    """The first convolution, 3 x 3 with stride 2, over SPAN px of a row at once."""

    def __init__(self, conv: PlainConv) -> None:
        super().__init__()
        packed = torch.zeros(SPAN // 2, len(conv.bias), SPAN, 3, 3, 2)  # px, O, px in, C, y, block
        for index in range(SPAN // 2):
            for x in range(3):
                block, px = divmod(2 * index + x - 1 + SPAN, SPAN)
                packed[index, :, px, :, :, block] = conv.weight.detach()[..., x]
        self.weight = nn.Parameter(packed.flatten(2, 3).flatten(0, 1))
        self.bias = nn.Parameter(conv.bias.detach().repeat(SPAN // 2))
        self.round = conv.round

    def forward(self, x: Tensor) -> Tensor:
        x = F.conv2d(F.pad(x, (1, 0, 1, 0)), self.weight, self.bias, (2, 1))
        # Rounding again changes no value, but marks the values as integers for the runtime.
        return self.round(unpack(self.round(torch.relu(x)), SPAN // 2))


class Integers(nn.Module):
    """uint8 crops -> outputs by name, scores as probabilities. Changes the net in place."""

    def __init__(self, net: nn.Module, outputs: list[str]) -> None:
        super().__init__()
        self.net, self.outputs = _laid_out(net), outputs

    def forward(self, rgb8: Tensor) -> tuple[Tensor, ...] | Tensor:
        n, h, w, _ = (int(side) for side in rgb8.shape)
        packed = rgb8.reshape(n, h, w // SPAN, 3 * SPAN).permute(0, 3, 1, 2)
        out = self.net((packed.float() - float(GREY)) * float(CODE))
        return out if isinstance(out, Tensor) else chosen(out, self.outputs)


def chosen(values: tuple[Tensor, ...], outputs: list[str]) -> tuple[Tensor, ...]:
    """The outputs asked for, of points, scores and mask; scores as probabilities."""
    points, scores, *mask = values
    named = {"points": points, "scores": scores.sigmoid(), "mask_logits": mask[0] if mask else None}
    return tuple(named[key] for key in outputs)


def _laid_out(net: nn.Module) -> nn.Module:
    last = net.paint[0] if isinstance(net, LipNet) else getattr(net, "out", None)
    named = list(net.named_modules())
    places = [(name, part) for name, part in named if isinstance(part, RoundedWeights)]
    for at, (name, part) in enumerate(places):
        if isinstance(part, RoundedLinear):
            plain: nn.Module = PlainLinear(part)
        else:
            count = len(part.bias)
            plain = PlainConv(part, count if part is last else max(count, PIECE))
        parent, _, own = name.rpartition(".")
        setattr(net.get_submodule(parent), own, FirstConv(plain) if at == 0 else plain)
    return net.eval()


class _Graph:
    """An exported graph, with access by name."""

    def __init__(self, model: onnx.ModelProto) -> None:
        self.graph = model.graph
        self.maker = {output: node for node in model.graph.node for output in node.output}
        self.values = {
            tensor.name: numpy_helper.to_array(tensor) for tensor in model.graph.initializer
        }
        for node in model.graph.node:
            if node.op_type == "Constant":
                self.values[node.output[0]] = numpy_helper.to_array(node.attribute[0].t)

    def keep(self, name: str, value: np.ndarray) -> str:
        self.graph.initializer.append(numpy_helper.from_array(np.asarray(value), name))
        self.values[name] = value
        return name

    def put(self, before: onnx.NodeProto, op: str, inputs: list[str], output: str, **how) -> None:
        node = helper.make_node(op, inputs, [output], name=output, **how)
        self.graph.node.insert(list(self.graph.node).index(before), node)
        self.maker[output] = node

    def drop(self, *nodes: onnx.NodeProto) -> None:
        for node in nodes:
            self.graph.node.remove(node)


def to_integers(path: Path, kept: tuple[str, ...] = ()) -> None:
    """Changes an exported file of Integers: its weights and its input become integers.

    kept: parts of the net that stay float.
    """
    model = onnx.load(path)
    graph = _Graph(model)
    for node in list(model.graph.node):
        if node.op_type == "Reshape" and len(graph.values[node.input[1]]) > 2:
            _reshape_any(graph, node)
    _read_codes(graph)
    for node in list(model.graph.node):
        if any(f"/{part}/" in node.name for part in kept):
            continue
        if node.op_type == "Conv":
            _take_pad_in(graph, node)
            _write_weights(graph, node)
        elif node.op_type == "Gemm" and "coefficients" in node.name:
            _round_flat(graph, node)
            _write_weights(graph, node)
    used = {name for node in model.graph.node for name in node.input}
    for tensor in [t for t in model.graph.initializer if t.name not in used]:
        model.graph.initializer.remove(tensor)
    onnx.checker.check_model(model)
    onnx.save(model, path)


def _reshape_any(graph: _Graph, node: onnx.NodeProto) -> None:
    """Lets the graph take any number of crops, and crops of any size where px are packed."""
    shape = graph.values[node.input[1]].copy()
    if len(shape) == 4:
        shape[:3] = 0, 0, -1  # 0: unchanged
    else:
        shape[0] = -1
    node.input[1] = graph.keep(f"{node.name}_shape", shape)


def _read_codes(graph: _Graph) -> None:
    """Replaces the input's Cast, Sub and Mul by integers with a scale and a zero point."""
    cast = next(node for node in graph.graph.node if node.op_type == "Cast")
    sub = next(node for node in graph.graph.node if cast.output[0] in node.input)
    mul = next(node for node in graph.graph.node if sub.output[0] in node.input)
    inputs = [cast.input[0], graph.keep("code", CODE), graph.keep("grey", GREY)]
    graph.put(cast, "DequantizeLinear", inputs, mul.output[0])
    graph.drop(cast, sub, mul)


def _take_pad_in(graph: _Graph, conv: onnx.NodeProto) -> None:
    """Merges one-sided padding, for which PyTorch writes a float node, into the convolution."""
    pad = graph.maker[conv.input[0]]
    if pad.op_type == "Pad":
        next(a for a in conv.attribute if a.name == "pads").ints[:] = [1, 1, 0, 0]
        conv.input[0] = pad.input[0]
        graph.drop(pad)


def _round_flat(graph: _Graph, gemm: onnx.NodeProto) -> None:
    """Marks values as integers again after Flatten. Otherwise the product would run in float."""
    flat = graph.maker[gemm.input[0]]
    how = graph.maker[flat.input[0]].input[1:]
    codes, read = f"{flat.name}_codes", f"{flat.name}_read"
    graph.put(gemm, "QuantizeLinear", [flat.output[0], *how], codes)
    graph.put(gemm, "DequantizeLinear", [codes, *how], read)
    gemm.input[0] = read


def _write_weights(graph: _Graph, node: onnx.NodeProto) -> None:
    """Writes int8 weights (O, ...), one step for each output, and the bias in steps of the sums."""
    weight, bias = (graph.values[name] for name in node.input[1:])
    step = (np.abs(weight).reshape(len(weight), -1).max(1) / WEIGHT_STEPS).astype(np.float32)
    step[step == 0] = 1
    column = step.reshape(-1, *[1] * (weight.ndim - 1))
    sums = step * graph.values[graph.maker[node.input[0]].input[1]]
    for at, codes, unit, dtype in (
        (1, weight / column, step, np.int8), (2, bias / sums, sums, np.int32),
    ):  # fmt: skip
        name = f"{node.name}_{at}"
        inputs = [
            graph.keep(f"{name}_codes", np.rint(codes).astype(dtype)),
            graph.keep(f"{name}_step", unit),
            graph.keep(f"{name}_zero", np.zeros(len(unit), dtype)),
        ]
        graph.put(node, "DequantizeLinear", inputs, f"{name}_read", axis=0)
        node.input[at] = f"{name}_read"
