"""The face nets: plain 3x3 convolutions, small enough for one thread."""

from typing import Any

import torch
from torch import Tensor, nn

# Log-odds by which a px must lie outside the mouth opening to be painted. Of the lips beside the
# opening of 284 measured photos 85 % are painted, where careful outlines cover 80 %; with less,
# more between the lips is painted as well.
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
# Where a mouth is round or hardly open, the net's border is some px off. So the colours of this
# very mouth count instead of redness: from the colour of what is surely opening to that of what is
# surely lip, a px has a share of lip. SHARE_WORTH: log-odds for each share beyond one half. Behind
# the lower lip a wide opening shows a tongue, whose colour is that of lips: of the opening's sure
# cells of 2 x 2 px, colours count in full up to the first of WIDE_CELLS, and from the second on
# only above the mean row of these cells. Below it redness counts.
SHARE_WORTH, WIDE_CELLS = 8.0, (25.0, 65.0)
# Surely lip: log-odds of the mouth over the first and of the opening below the second number.
# Surely opening: over the third. There weights go from 0 to 1, the fourth number says how steeply.
SURE_MOUTH, SURE_LIP, SURE_OPENING, SURE_STEEP = 2.0, -1.0, 2.0, 2.0
# Bound of log-odds times SURE_STEEP: beyond, weights would be denormal numbers, which take long.
SURE_MOST = 20.0
FEW_CELLS = 5.0  # with fewer sure cells of lip or opening, redness counts more
# Variances of Y', Cb and Cr in code values that lip and opening are taken to have, and the squared
# distance of their colours, in deviations, at which colours count half. With less than 400 of Y'
# some edges of the sample's teeth are taken for lip.
VARIANCES, HALF_CONTRAST = (400.0, 20.0, 20.0), 4.0
# From R'G'B', BT.601.
YCBCR = (0.299, 0.587, 0.114), (-0.168736, -0.331264, 0.5), (0.5, -0.418688, -0.081312)

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
        self.colour, self.lipstick = Colour(), Lipstick()

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
        return points, score, self.lipstick(cells, self.colour(crop, cells))


class Colour(nn.Module):
    """Crops in [-1, 1], (N, 3, H, W), and mouth and opening in 2 x 2 cells, (N, 8, H/2, W/2) ->
    log-odds of lip by the colour of each px of a cell, (N, 4, H/2, W/2)."""

    def __init__(self) -> None:
        super().__init__()
        pick = torch.eye(4).view(1, 4, 1, 2, 2) * torch.tensor(YCBCR).view(3, 1, 3, 1, 1)
        # Of a cell's mean mouth and opening: sure lip is the product of the first and the third
        # sigmoid, sure opening that of the second and the fourth, which is 1.
        sure = SURE_STEEP / 4 * torch.tensor([(1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.0, 0.0)])
        off = SURE_STEEP * torch.tensor([-SURE_MOUTH, -SURE_OPENING, SURE_LIP, SURE_MOST])
        constants = {
            "pick": 127.5 * pick.flatten(0, 1), "none": torch.zeros(12), "off": off,
            "sure": sure.repeat_interleave(4, 1)[:, :, None, None],
            "variances": torch.tensor(VARIANCES),
        }  # fmt: skip
        for name, values in constants.items():  # not of a checkpoint: nothing here is learned
            self.register_buffer(name, values, persistent=False)

    def forward(self, crop: Tensor, cells: Tensor) -> Tensor:
        high, wide = (int(side) for side in cells.shape[2:])
        count = high * wide
        colours = nn.functional.conv2d(crop, self.pick, self.none, 2).reshape(-1, 3, 4 * count)
        of_cells = colours.reshape(-1, 3, 4, count).mean(2)
        sure = nn.functional.conv2d(cells, self.sure, self.off).clamp(-SURE_MOST, SURE_MOST)
        sure = sure.reshape(-1, 4, count).sigmoid()
        weights = sure[:, :2] * sure[:, 2:]  # (N, 2, cells)
        rows = torch.arange(high, device=cells.device).float()
        row_of_cell = rows.repeat_interleave(wide)[:, None]
        total = weights.sum(2, keepdim=True)
        mean = weights @ of_cells.transpose(1, 2) / (total + 1e-6)  # (N, 2, 3)
        evidence = self.evidence(colours, mean).reshape(-1, 4, high, wide)
        inside, (full, none) = total[:, 1:], WIDE_CELLS
        middle_row = weights[:, 1:] @ row_of_cell / (inside + 1e-6)
        # colours count above the middle row, and everywhere in a narrow mouth
        above, narrow = middle_row + 0.5 - rows, (none - inside) / (none - full)
        counts = torch.maximum(narrow, above).clamp(0, 1)
        counts = counts * (total.amin(1, keepdim=True) / FEW_CELLS).clamp(max=1)  # (N, 1, rows)
        red = colours.reshape(-1, 12, high, wide)[:, 8:]
        redness = self.redness(red, of_cells.reshape(-1, 3, high, wide)[:, 2:])
        return redness + counts.reshape(-1, 1, high, 1) * (evidence - redness)

    @staticmethod
    def redness(red: Tensor, of_cells: Tensor) -> Tensor:
        """Log-odds of lip by Cr (N, 4, H, W), beside its mean around. of_cells: (N, 1, H, W)."""
        size, beyond = AROUND_CELLS, AROUND_CELLS // 2
        around = nn.functional.avg_pool2d(of_cells, size, 1, beyond, count_include_pad=False)
        return (REDNESS * (red - around)).clamp(max=REDNESS_MOST)

    def evidence(self, colours: Tensor, mean: Tensor) -> Tensor:
        """Log-odds of lip (N, 1, P) by colours (N, 3, P). mean: (N, 2, 3), of lip and opening."""
        lip, inside = mean.chunk(2, 1)
        apart = (lip - inside) / self.variances
        contrast = ((lip - inside) * apart).sum(2, keepdim=True)  # (N, 1, 1)
        worth = SHARE_WORTH / (contrast + HALF_CONTRAST)
        half_way = ((lip + inside) * apart).sum(2, keepdim=True) / 2
        most = contrast / 2
        return worth * (apart @ colours - half_way).clamp(-most, most)


class NoColour(nn.Module):
    """Takes the place of Colour in a net in integers, which sees the crop laid out otherwise."""

    def forward(self, crop: Tensor, _cells: Tensor) -> Tensor:
        return crop.new_zeros(1)


def lipstick_logits(logits: Tensor, colour: Tensor) -> Tensor:
    """Whole mouth and opening, (N, 2 C, H, W) -> log-odds of lipstick (N, C, H, W).

    colour: evidence of lip in log-odds, (N, C, H, W) or one number for all.
    """
    half = int(logits.shape[1]) // 2
    mouth, opening = logits[:, :half], logits[:, half:]
    surest = opening.amax((1, 2, 3), keepdim=True)
    opened, ajar = (surest / OPENED).clamp(0, 1), (surest / AJAR).clamp(0, 1)
    near = (opening / -REDNESS_FROM + 1).clamp(0, 1)
    evidence = opened * torch.maximum(colour, -REDNESS_MOST * near)
    margin = SHUT_MARGIN + (OPENING_MARGIN - SHUT_MARGIN) * ajar
    return torch.minimum(mouth, evidence - opening - margin)


class Lipstick(nn.Module):
    """Mouth and opening in 2 x 2 cells, (N, 8, H/2, W/2), and the evidence of colours,
    (N, 4, H/2, W/2) -> log-odds of lipstick (N, H, W)."""

    def forward(self, cells: Tensor, colour: Tensor) -> Tensor:
        return nn.functional.pixel_shuffle(lipstick_logits(cells, colour), 2)[:, 0]


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
