"""The face nets: plain 3x3 convolutions, small enough for one thread."""

from typing import Any

import torch
from torch import Tensor, nn

# A px of the mouth is painted if its log-odds of lying outside the opening exceed MARGIN.
# DOUBT_MARGIN is enough for a px that is neither tooth nor darker than its surroundings: there,
# bare lip would be noticed, but a little paint on the opening's side of the border would not.
MARGIN, DOUBT_MARGIN = 1.08, -2.4
TEETH_SURE = 4.0  # beyond these log-odds of teeth, either way, one of the margins holds alone
LIGHT, NEAR_PX = 0.42, 4  # dark: below this share of the highest brightness within so many px
# Log-odds for the whole range of brightness. Px of the border mix lip and dark, so they are painted
# in part. When they were painted fully or not at all, the bare ones stood out as a pale line.
FOR_LIGHT = 14.0
# The net draws the border of the opening softer than it is, so its log-odds are multiplied by this.
SHARPER = 3.0

# 3x3 convolutions throughout: per multiplication ONNX Runtime computes them about twice as
# fast as depthwise ones, and they train in bfloat16 where depthwise ones do not.


class Conv(nn.Sequential):
    def __init__(self, inputs: int, outputs: int, stride: int = 1, relu: bool = True) -> None:
        super().__init__(
            nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False),
            nn.BatchNorm2d(outputs),
            *([nn.ReLU(inplace=True)] if relu else []),
        )


class Residual(nn.Module):
    def __init__(self, channels: int, convolutions: int = 2) -> None:
        super().__init__()
        before = [Conv(channels, channels) for _ in range(convolutions - 1)]
        self.body = nn.Sequential(*before, Conv(channels, channels, relu=False))

    def forward(self, x: Tensor) -> Tensor:
        return torch.relu(x + self.body(x))


def stage(inputs: int, outputs: int, residuals: int) -> nn.Sequential:
    return nn.Sequential(Conv(inputs, outputs, 2), *[Residual(outputs) for _ in range(residuals)])


class Join(nn.Module):
    """Adds a coarse level, upsampled by two, to a finer level."""

    def __init__(self, mode: str) -> None:
        """mode: the interpolation, as in nn.Upsample."""
        super().__init__()
        self.up = nn.Upsample(scale_factor=2, mode=mode)

    def forward(self, coarse: Tensor, fine: Tensor) -> Tensor:
        return self.up(coarse) + fine


class PointHead(nn.Module):
    """Features -> coefficients of a shape basis -> points. The basis starts as a PCA."""

    def __init__(self, features: int, mean: Tensor, basis: Tensor) -> None:
        super().__init__()
        self.drop = nn.Dropout(0.1)
        self.coefficients = nn.Linear(features, len(basis))
        self.mean = nn.Parameter(mean.clone())  # (K, 3) in IOD from the crop's centre
        self.basis = nn.Parameter(basis.clone())  # (C, K*3), scaled by its deviations

    def forward(self, x: Tensor) -> Tensor:
        coefficients = self.coefficients(self.drop(x.flatten(1)))  # (N, C)
        with torch.autocast("cpu", enabled=False):  # bfloat16 is too coarse for positions
            moved = torch.addmm(self.mean.flatten(), coefficients.float(), self.basis)
            return moved.view(-1, *self.mean.shape)  # (N, K, 3)


class PointNet(nn.Module):
    """Crops -> points (N, K, 3) in IOD from the centre, and two logits: a face, a visible mouth."""

    def __init__(
        self,
        size_wh: tuple[int, int],
        channels: tuple[int, ...],
        residuals: tuple[int, ...],
        mean: Tensor,
        basis: Tensor,
    ) -> None:
        super().__init__()
        stages, inputs = [], 3
        for outputs, count in zip(channels, residuals, strict=True):
            stages.append(stage(inputs, outputs, count))
            inputs = outputs
        self.stages = nn.ModuleList(stages)
        shrink = 2 ** len(channels)
        cells = -(-size_wh[0] // shrink) * -(-size_wh[1] // shrink)
        self.points = PointHead(inputs * cells, mean, basis)
        self.score = nn.Linear(inputs * cells, 2)

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor]:
        for block in self.stages:
            x = block(x)
        return self.points(x), self.score(x.flatten(1)).float()


class PaintCells(nn.Conv2d):
    """A convolution to the px of cells of 2 x 2 px, each averaged with its neighbours in the row,
    (1 2 1) / 4.

    The two columns of a cell have weights of their own, so their values differ where the net is
    unsure. Without the average, lips would be painted in a comb, with every second column bare.
    """

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__(inputs, outputs, 1)
        shares = torch.zeros(3, outputs, outputs)  # of the cells at the left, here, at the right
        for px in range(outputs):
            beside = px ^ 1  # the other column of the cell
            shares[1, px, px], shares[1, px, beside] = 0.5, 0.25
            shares[2 * (px % 2), px, beside] = 0.25
        self.register_buffer("shares", shares, persistent=False)

    def forward(self, features: Tensor) -> Tensor:
        """(N, C, H/2, W/2) -> (N, 4 V, H/2, W/2): V values for the four px of each cell."""
        return nn.functional.conv2d(features, *self._averaged(), padding=(0, 1))

    def _averaged(self) -> tuple[Tensor, Tensor]:
        """The weight (4 V, C, 1, 3) and the bias of a convolution that includes the average."""
        weight = torch.einsum("kpo,oc->pck", self.shares, self.weight[:, :, 0, 0])[:, :, None]
        return weight, self.shares.sum(0) @ self.bias

    @torch.no_grad()
    def as_conv(self) -> nn.Conv2d:
        """A plain convolution that computes the same, for export."""
        conv = nn.Conv2d(self.in_channels, self.out_channels, (1, 3), padding=(0, 1))
        for values, averaged in zip((conv.weight, conv.bias), self._averaged(), strict=True):
            values.copy_(averaged)
        return conv


def weight_of_px(weight: Tensor) -> Tensor:
    """The parameter of PaintCells for the weight (4 V, C, 1, 3) of its `as_conv`."""
    px = torch.arange(len(weight))
    of_px = torch.empty_like(weight[..., :1])
    of_px[px ^ 1, :, 0, 0] = 4 * weight[px, :, 0, 2 * (px % 2)]
    return of_px


class LipNet(PointNet):
    """A PointNet with a third output: log-odds of lipstick (N, H, W).

    In training that output is (N, 3, H, W), from which the log-odds follow: the whole mouth (lips
    and all that shows between them) against skin, the opening between the lips against all else,
    and in the opening teeth against tongue, gums and the dark.
    """

    def __init__(self, size_wh: tuple[int, int], channels: tuple[int, ...], *rest: Any) -> None:
        """The parameters are those of PointNet, with four channels."""
        super().__init__(size_wh, channels, *rest)
        first, second, third, fourth = channels
        self.down = nn.ModuleList([
            nn.Conv2d(fourth, third, 1), nn.Conv2d(third, second, 1), nn.Conv2d(second, first, 1),
            nn.Conv2d(first, first, 1),
        ])  # fmt: skip
        self.join = nn.ModuleList([Join("bilinear") for _ in range(3)])
        self.merge = nn.ModuleList([
            Conv(third, third), Conv(second, second),
            nn.Sequential(Conv(first, first), Residual(first, 1)),
        ])  # fmt: skip
        # Twelve values per cell of 2 x 2 px: three for each px.
        self.paint = nn.Sequential(PaintCells(first, 12), nn.PixelShuffle(2))

    def forward(self, crop: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        levels, x = [], crop
        for block in self.stages:
            x = block(x)
            levels.append(x)
        points, score = self.points(x), self.score(x.flatten(1)).float()
        skips = [levels[2], levels[1], self.down[3](levels[0])]
        for down, join, skip, merge in zip(self.down, self.join, skips, self.merge, strict=False):
            x = merge(join(down(x), skip))
        cells = self.paint[0](x).float()
        if self.training:
            return points, score, self.paint[1](cells)
        return points, score, lipstick_logits(cells, crop)


def lipstick_logits(cells: Tensor, crop: Tensor) -> Tensor:
    """Mouth, opening and teeth in cells of 2 x 2 px, and the crop -> log-odds of lipstick.

    (N, 12, H/2, W/2), (N, 3 P, H, W/P) in [-1, 1] -> (N, H, W). P: number of px side by side that
    the crop holds as one (export_int8.py). A gap of at most 2 NEAR_PX between painted px, such as
    the line of shut lips, is painted although it is dark.
    """
    mouth, opening, teeth = cells[:, :4], cells[:, 4:8], cells[:, 8:]
    toothed = (teeth / (2 * TEETH_SURE) + 0.5).clamp(0, 1)
    margins = MARGIN, DOUBT_MARGIN + (MARGIN - DOUBT_MARGIN) * toothed
    parts = [torch.minimum(mouth, SHARPER * (-opening - margin)) for margin in margins]
    sure, doubtful = nn.functional.pixel_shuffle(torch.cat(parts, 1), 2).split(1, 1)
    brightness = _mean_colour(crop) / 2 + 0.5
    light = FOR_LIGHT * (brightness - LIGHT * _highest_near(brightness))
    gap = -_highest_near(-_highest_near(sure))
    lipstick = torch.maximum(sure, torch.minimum(doubtful, torch.maximum(light, gap)))
    return lipstick[:, 0]


def _mean_colour(crop: Tensor) -> Tensor:
    if crop.shape[1] == 3:
        return crop.mean(1, keepdim=True)
    n, channels, h, w = (int(side) for side in crop.shape)
    of_px = crop.reshape(n, channels // 3, 3, h, w).mean(2)  # (N, P, H, W/P)
    return of_px.permute(0, 2, 3, 1).reshape(n, h, w * channels // 3)[:, None]


def _highest_near(x: Tensor) -> Tensor:
    return nn.functional.max_pool2d(x, 2 * NEAR_PX + 1, 1, NEAR_PX)


def normalise(rgb8: Tensor) -> Tensor:
    """(N, H, W, 3) uint8 -> (N, 3, H, W) in [-1, 1]."""
    return rgb8.permute(0, 3, 1, 2).float() / 127.5 - 1


SHAPES = {  # channels, residual blocks, coefficients
    "mesh": ((16, 32, 48, 96, 160), (0, 1, 1, 1, 1), 100),
    "lips": ((16, 24, 48, 96), (0, 1, 1, 1), 60),
    "eye": ((16, 32, 64, 96), (0, 1, 1, 1), 40),
}


def build(name: str, size_wh: tuple[int, int], targets: Tensor) -> PointNet:
    """A new net, with a shape basis fitted to targets (M, K, 3)."""
    channels, residuals, coefficients = SHAPES[name]
    mean = targets.mean(0)
    flat = (targets - mean).flatten(1).double()
    _, deviations, directions = torch.linalg.svd(flat, full_matrices=False)
    basis = directions[:coefficients] * deviations[:coefficients, None] / len(flat) ** 0.5
    kind = LipNet if name == "lips" else PointNet
    return kind(size_wh, channels, residuals, mean, basis.float())
