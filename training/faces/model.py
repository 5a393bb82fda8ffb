"""The face nets: plain 3x3 convolutions, small enough for one thread."""

from typing import Any

import torch
from torch import Tensor, nn

# Log-odds by which a px must lie outside the mouth opening to be painted. Of the lips beside the
# opening of 284 measured photos 82 % are painted with 0.75, a little more than careful outlines
# cover, and 83 % with 0.5, but then 3.4 rather than 3.0 % of their area between them.
OPENING_MARGIN = 0.75
# The same for a shut mouth, whose surest px of the opening has log-odds of at most 0; it grows to
# OPENING_MARGIN until that has AJAR. In the line where lips meet the net is unsure, and with the
# margin of an open mouth a band of bare lip stays along it.
SHUT_MARGIN, AJAR = -0.25, 1.0
# The net draws the border of the opening softer than the picture shows it. Lips are redder than
# teeth, gaps and most tongues, so a px of the open mouth that is redder than the px around it more
# likely is lip: REDNESS, log-odds for each code value of Cr, at most REDNESS_MOST either way. Less
# red, such as a highlight, counts only from REDNESS_FROM on, in log-odds of the opening, and fully
# from 0 on. All of it counts where the surest px of the opening has log-odds of OPENED or more, and
# none where they are below 0: a shut mouth keeps its mask. REDNESS was fitted on the mouths of
# lip_outlines.py.
REDNESS, REDNESS_MOST, REDNESS_FROM, OPENED = 0.2, 2.0, -1.0, 2.0
AROUND_CELLS = 5  # cells of 2 x 2 px: the side of the square over which redness is averaged
CR = 0.5, -0.418688, -0.081312  # of R'G'B', BT.601

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
    def __init__(self, channels: int) -> None:
        super().__init__()
        self.body = nn.Sequential(Conv(channels, channels), Conv(channels, channels, relu=False))

    def forward(self, x: Tensor) -> Tensor:
        return torch.relu(x + self.body(x))


def stage(inputs: int, outputs: int, residuals: int) -> nn.Sequential:
    return nn.Sequential(Conv(inputs, outputs, 2), *[Residual(outputs) for _ in range(residuals)])


class Join(nn.Module):
    """Adds a coarse level, upsampled by two, to a finer level."""

    def __init__(self, mode: str) -> None:
        """mode: the interpolation, as of nn.Upsample."""
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


class LipNet(PointNet):
    """A PointNet with a third output: log-odds of lipstick (N, H, W).

    In training that output is (N, 2, H, W), from which the log-odds follow: the whole mouth (lips
    and all that shows between them) against skin, and the opening between the lips against all
    else.
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
        self.merge = nn.ModuleList([Conv(third, third), Conv(second, second), Conv(first, first)])
        # Eight values per cell of 2 x 2 px: two for each px.
        self.paint = nn.Sequential(nn.Conv2d(first, 8, 1), nn.PixelShuffle(2))
        self.redness, self.lipstick = Redness(), Lipstick()

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
        return points, score, self.lipstick(cells, self.redness(crop))


class Redness(nn.Module):
    """Crops in [-1, 1], (N, 3, H, W) -> log-odds of lip by how red each px of a 2 x 2 cell is
    beside those around it, (N, 4, H/2, W/2)."""

    def __init__(self) -> None:
        super().__init__()
        pick = torch.eye(4).view(4, 1, 2, 2) * torch.tensor(CR).view(1, 3, 1, 1)
        # not of a checkpoint: nothing here is learned
        self.register_buffer("pick", 127.5 * REDNESS * pick, persistent=False)
        self.register_buffer("none", torch.zeros(4), persistent=False)

    def forward(self, crop: Tensor) -> Tensor:
        red = nn.functional.conv2d(crop, self.pick, self.none, 2)
        size, beyond = AROUND_CELLS, AROUND_CELLS // 2
        mean = red.mean(1, keepdim=True)
        around = nn.functional.avg_pool2d(mean, size, 1, beyond, count_include_pad=False)
        return red - around


class NoRedness(nn.Module):
    """Takes the place of Redness in a net in integers, which sees the crop laid out otherwise."""

    def forward(self, crop: Tensor) -> Tensor:
        return crop.new_zeros(1)


def lipstick_logits(logits: Tensor, redness: Tensor) -> Tensor:
    """Whole mouth and opening, (N, 2 C, H, W) -> log-odds of lipstick (N, C, H, W).

    redness: evidence of lip in log-odds, (N, C, H, W) or one number for all.
    """
    half = int(logits.shape[1]) // 2
    mouth, opening = logits[:, :half], logits[:, half:]
    surest = opening.amax((1, 2, 3), keepdim=True)
    opened, ajar = (surest / OPENED).clamp(0, 1), (surest / AJAR).clamp(0, 1)
    near = (opening / -REDNESS_FROM + 1).clamp(0, 1)
    evidence = opened * torch.maximum(redness.clamp(max=REDNESS_MOST), -REDNESS_MOST * near)
    margin = SHUT_MARGIN + (OPENING_MARGIN - SHUT_MARGIN) * ajar
    return torch.minimum(mouth, evidence - opening - margin)


class Lipstick(nn.Module):
    """Mouth and opening in 2 x 2 cells, (N, 8, H/2, W/2), and the evidence of redness,
    (N, 4, H/2, W/2) -> log-odds of lipstick (N, H, W)."""

    def forward(self, cells: Tensor, redness: Tensor) -> Tensor:
        return nn.functional.pixel_shuffle(lipstick_logits(cells, redness), 2)[:, 0]


def normalise(rgb8: Tensor) -> Tensor:
    """(N, H, W, 3) uint8 -> (N, 3, H, W) in [-1, 1]."""
    return rgb8.permute(0, 3, 1, 2).float() / 127.5 - 1


SHAPES = {  # channels, residual blocks, coefficients
    "mesh": ((16, 32, 48, 96, 160), (0, 1, 1, 1, 1), 100),
    "lips": ((12, 24, 48, 96), (0, 1, 1, 1), 60),
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
