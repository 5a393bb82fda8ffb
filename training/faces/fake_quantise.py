"""Fake quantisation: 7-bit weights, 8-bit activations; the heads stay float.

`rounded` turns a trained net into one whose convolutions round their weights and outputs. That net
can be trained further (train_quantised.py), and export_int8.py writes it as ONNX with the same
numbers, so the net that runs is the net that was trained.
"""

import torch
from makeup_video.training.faces.model import Conv, Join, PointHead, Residual
from torch import Tensor, nn

# 7-bit weights: processors without VNNI add two 8-bit products in 16 bits, which could overflow.
WEIGHT_STEPS = 63
STEPS = 255
# Parts that stay float. Rounding the last stage of the mesh net moves the points by as much as
# rounding all stages before it, and that stage is an eighth of the work. The last convolution of
# the lip net is hardly any work, and a step of its output would be a tenth in log-odds.
KEPT = {"mesh": ("stages.4", "points"), "lips": ("paint.0",)}


class Round(nn.Module):
    """Rounds an activation to one of 256 values.

    Until `settle` is called, the module observes the range of the values. From then on it rounds
    them, and learns the step.
    """

    def __init__(self, signed: bool) -> None:
        """signed: values may be negative; otherwise they come from a ReLU."""
        super().__init__()
        self.signed, self.observing = signed, True
        self.beyond = 0.0  # share of values that may lie beyond the range, at either end
        self.scale = nn.Parameter(torch.ones(1))
        self.register_buffer("zero", torch.zeros(1))  # the integer that means 0
        self.register_buffer("lowest", torch.zeros(1))
        self.register_buffer("highest", torch.zeros(1))

    def settle(self) -> None:
        """Begin to round between the lowest and the highest value observed."""
        self.observing = False
        with torch.no_grad():
            self.scale.copy_(((self.highest - self.lowest) / STEPS).clamp(min=1e-6))
            self.zero.copy_((-self.lowest / self.scale).round())

    def set_range(self, lowest: Tensor, highest: Tensor) -> None:
        """Round between these two values; 0 stays one of the rounded values."""
        self.lowest.copy_(lowest)
        self.highest.copy_(highest)
        self.settle()

    def forward(self, x: Tensor) -> Tensor:
        if self.observing:
            self._observe(x.detach().flatten())
            return x
        if self.training:
            return torch._fake_quantize_learnable_per_tensor_affine(
                x, self.scale, self.zero, 0, STEPS, 1.0
            )
        scale, zero = self.scale.item(), int(self.zero.item())
        return torch.fake_quantize_per_tensor_affine(x, scale, zero, 0, STEPS)

    def _observe(self, values: Tensor) -> None:
        beyond = max(1, int(values.numel() * self.beyond))
        if self.signed:
            self.lowest.copy_(torch.minimum(self.lowest, values.kthvalue(beyond)[0]))
        self.highest.copy_(torch.maximum(self.highest, -(-values).kthvalue(beyond)[0]))


class RoundedWeights(nn.Module):
    """Weights (O, ...) as multiples of one step for each output."""

    def __init__(self, weight: Tensor, bias: Tensor) -> None:
        super().__init__()
        self.weight, self.bias = nn.Parameter(weight.clone()), nn.Parameter(bias.clone())

    def rounded(self) -> Tensor:
        """The rounded weights; in training, gradients pass through the rounding."""
        highest = self.weight.detach().abs().flatten(1).amax(1).clamp(min=1e-8)
        step = (highest / WEIGHT_STEPS).view(-1, *[1] * (self.weight.ndim - 1))
        weight = (self.weight.detach() / step).round() * step
        return weight + self.weight - self.weight.detach() if self.training else weight


class RoundedConv(RoundedWeights):
    """A convolution with its batch norm folded in, followed by a ReLU if `relu`."""

    def __init__(self, conv: nn.Conv2d, norm: nn.BatchNorm2d | None, relu: bool) -> None:
        weight, bias = conv.weight.detach(), conv.bias
        bias = torch.zeros(len(weight)) if bias is None else bias.detach()
        if norm is not None:
            gain = norm.weight.detach() / (norm.running_var + norm.eps).sqrt()
            weight = weight * gain[:, None, None, None]
            bias = norm.bias.detach() + (bias - norm.running_mean) * gain
        super().__init__(weight, bias)
        self.stride, self.padding, self.relu = conv.stride, conv.padding, relu
        self.round = Round(signed=not relu)

    def forward(self, x: Tensor) -> Tensor:
        x = nn.functional.conv2d(x, self.rounded(), self.bias, self.stride, self.padding)
        return self.round(torch.relu(x) if self.relu else x)


class RoundedLinear(RoundedWeights):
    """The layer of the shape coefficients: only its weights are rounded."""

    def forward(self, x: Tensor) -> Tensor:
        return nn.functional.linear(x, self.rounded(), self.bias)


class RoundedResidual(nn.Module):
    def __init__(self, body: nn.Sequential) -> None:
        super().__init__()
        self.body, self.round = body, Round(signed=False)

    def forward(self, x: Tensor) -> Tensor:
        return self.round(torch.relu(x + self.body(x)))


class RoundedJoin(nn.Module):
    def __init__(self, up: nn.Module) -> None:
        super().__init__()
        self.up, self.round_up, self.round = up, Round(signed=True), Round(signed=True)

    def forward(self, coarse: Tensor, fine: Tensor) -> Tensor:
        return self.round(self.round_up(self.up(coarse)) + fine)


def rounded(net: nn.Module, kept: tuple[str, ...] = ()) -> nn.Module:
    """Rounds a trained net in place, except for the parts `kept`.

    The net's input is then (x - 128) / 127.5, where x is a code value. The offset is 128 rather
    than 127.5, because the padding beyond a crop's border must be an integer, too.
    """
    whole = {net.get_submodule(name) for name in kept}
    net = _rounded_parts(net.eval(), whole)
    first = next(part for part in net.modules() if isinstance(part, RoundedConv))
    with torch.no_grad():
        first.bias += first.weight.sum((1, 2, 3)) * (0.5 / 127.5)
    return net


def roundings(net: nn.Module) -> list[Round]:
    return [part for part in net.modules() if isinstance(part, Round)]


def _rounded_parts(module: nn.Module, whole: set[nn.Module]) -> nn.Module:
    for name, child in module.named_children():
        setattr(module, name, child if child in whole else _rounded_part(child, whole))
    return module


def _rounded_part(part: nn.Module, whole: set[nn.Module]) -> nn.Module:
    if isinstance(part, Conv):
        return RoundedConv(part[0], part[1], relu=len(part) > 2)
    if isinstance(part, nn.Conv2d):
        return RoundedConv(part, None, relu=False)
    if isinstance(part, Residual):
        return RoundedResidual(_rounded_parts(part.body, whole))
    if isinstance(part, Join):
        return RoundedJoin(part.up)
    if isinstance(part, PointHead):
        of = part.coefficients
        part.coefficients = RoundedLinear(of.weight.detach(), of.bias.detach())
        return part
    return _rounded_parts(part, whole)
