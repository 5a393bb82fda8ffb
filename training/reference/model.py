"""EfficientNet-lite with a small head: a crop -> targets, the scaled numbers of a product.

Beside the pooled features, the head gets the colours of the crop, averaged over squares: batch
norms pass on colour only relative to the rest of the batch, and colour is what the net must read.
Lids lie flat in their crop, and each zone is always in the same squares, so two dense layers learn
a lot from the squares.
"""

import math

import torch
from makeup_video.pipeline.reference.crops import CROPS
from torch import Tensor, nn

# Scales of width and of depth.
SIZES = {
    "lite0": (1.0, 1.0), "lite1": (1.0, 1.1), "lite2": (1.1, 1.2),
    "lite3": (1.2, 1.4), "lite4": (1.4, 1.8),
}  # fmt: skip
# Kernel, stride, expansion, channels, blocks of EfficientNet-B0.
STAGES = (
    (3, 1, 1, 16, 1), (3, 2, 6, 24, 2), (5, 2, 6, 40, 2), (3, 2, 6, 80, 3),
    (5, 1, 6, 112, 3), (5, 2, 6, 192, 4), (3, 1, 6, 320, 1),
)  # fmt: skip
STEM, HEAD = 32, 1280
EPSILON, MOMENTUM = 1e-3, 0.03  # of the batch norms
HEAD_SIGMA = 0.003  # of the first weights: small, so that the first outputs are about the mean
LEAK = 0.1  # of the last ReLU in training, so that a number below 0 for all crops can recover
SQUARE = {"lips": 16, "eyes": 8}  # px of the squares whose colours the head gets; lids are thin
HIDDEN = {"lips": (), "eyes": (512, 512)}  # widths of dense layers between squares and head
SPREAD = 3.0  # makes the colours of squares differ by about 1, which suits the dense layers


def scaled_width(channels: int, width: float) -> int:
    """The scaled width as a multiple of 8, never more than a tenth below the exact number."""
    exact = channels * width
    whole = max(8, int(exact + 4) // 8 * 8)
    return whole + 8 if whole < 0.9 * exact else whole


class Conv(nn.Sequential):
    def __init__(
        self, inputs: int, outputs: int, kernel: int, stride: int = 1, groups: int = 1,
        relu: bool = True,
    ) -> None:  # fmt: skip
        super().__init__(
            nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, groups=groups, bias=False),
            nn.BatchNorm2d(outputs, EPSILON, MOMENTUM),
            *([nn.ReLU6(inplace=True)] if relu else []),
        )


class Block(nn.Module):
    """An inverted residual: expand, depthwise, project; added to its input where shapes agree."""

    def __init__(self, inputs: int, outputs: int, kernel: int, stride: int, expansion: int) -> None:
        super().__init__()
        wide = inputs * expansion
        self.body = nn.Sequential(
            *([Conv(inputs, wide, 1)] if expansion > 1 else []),
            Conv(wide, wide, kernel, stride, wide),
            Conv(wide, outputs, 1, relu=False),
        )
        self.adds = stride == 1 and inputs == outputs

    def forward(self, x: Tensor) -> Tensor:
        out: Tensor = self.body(x)
        return x + out if self.adds else out


class ReferenceNet(nn.Module):
    """Crops (N, 3, H, W) in [-1, 1] -> targets (N, K), none below 0."""

    def __init__(self, size: str, mean: Tensor, region: str, shrink: int = 1) -> None:
        """mean: (K,) of the targets, all above 0, so that the ReLU of the head starts active.

        region: "lips" or "eyes". shrink: how many times smaller the crop is made first.
        """
        super().__init__()
        self.shrink, self.square = shrink, SQUARE[region]
        width, depth = SIZES[size]
        blocks, inputs = [], STEM
        for number, (kernel, stride, expansion, channels, count) in enumerate(STAGES):
            outputs = scaled_width(channels, width)
            ends = number in (0, len(STAGES) - 1)
            for at in range(count if ends else math.ceil(count * depth)):
                blocks.append(Block(inputs, outputs, kernel, 1 if at else stride, expansion))
                inputs = outputs
        self.stem = Conv(3, STEM, 3, 2)
        self.blocks = nn.Sequential(*blocks)
        self.top = Conv(inputs, HEAD, 1)
        self.drop = nn.Dropout(0.1)
        wide = 3 * math.prod(side // self.square for side in CROPS[region].input_wh)
        layers: list[nn.Module] = []
        for hidden in HIDDEN[region]:
            layers += [nn.Linear(wide, hidden), nn.GELU()]
            wide = hidden
        self.colours = nn.Sequential(*layers)
        self.head = nn.Linear(HEAD + wide, len(mean))
        for conv in self.modules():
            if isinstance(conv, nn.Conv2d):  # He et al., 2015, by fan-out
                fan = conv.weight[0, 0].numel() * conv.out_channels // conv.groups
                nn.init.normal_(conv.weight, 0, (2 / fan) ** 0.5)
        nn.init.normal_(self.head.weight, 0, HEAD_SIGMA)
        with torch.no_grad():
            self.head.bias.copy_(mean)

    def squares(self, x: Tensor) -> Tensor:
        """(N, S) colours of the squares of crops, as the dense layers take them."""
        colours = nn.functional.avg_pool2d(x, self.square).flatten(1)
        return SPREAD * colours if len(self.colours) else colours

    def forward(self, x: Tensor) -> Tensor:
        colours = self.colours(self.squares(x))
        if self.shrink > 1:
            x = nn.functional.avg_pool2d(x, self.shrink)
        x = self.top(self.blocks(self.stem(x)))  # (N, 1280, H/32, W/32) of the shrunk crop
        x = self.head(torch.cat([self.drop(x.mean((2, 3))), colours], 1))
        return nn.functional.leaky_relu(x, LEAK) if self.training else torch.relu(x)
