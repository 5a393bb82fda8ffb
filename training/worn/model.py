"""The net that reads what is worn: three small towers of convolutions, for eyes, face and lips."""

import torch
from makeup_video.pipeline.reference.makeup_input import PLACES
from torch import Tensor, nn
from torch.nn import functional

CHANNELS = (16, 32, 48, 64, 64)
# How much smaller each part is made: most photos of the training are small, but a line along the
# lashes is thin.
SHRINK = {"eyes": 1, "face": 2, "lips": 2}


class Tower(nn.Sequential):
    """(N, 3, H, W) -> (N, 2 * CHANNELS[-1]): means and maxima of the last features."""

    def __init__(self, shrink: int) -> None:
        """shrink: how much smaller the input is made first."""
        layers: list[nn.Module] = []
        before = 3
        for number, channels in enumerate(CHANNELS[: len(CHANNELS) - shrink + 1]):
            layers += _block(before, channels, 2)
            if number:
                layers += _block(channels, channels, 1)
            before = channels
        super().__init__(*layers)
        self.shrink = shrink

    def forward(self, x: Tensor) -> Tensor:
        features = super().forward(functional.avg_pool2d(x, self.shrink))
        return torch.cat([features.mean((2, 3)), features.amax((2, 3))], 1)


def _block(before: int, channels: int, stride: int) -> list[nn.Module]:
    return [
        nn.Conv2d(before, channels, 3, stride, 1, bias=False),
        nn.BatchNorm2d(channels),
        nn.ReLU(inplace=True),
    ]


class MakeupNet(nn.Module):
    """Inputs (N, 160, 192, 3) uint8 -> log-odds of what is worn and the numbers of the look."""

    def __init__(self, labels: int, numbers: int) -> None:
        super().__init__()
        self.towers = nn.ModuleDict({part: Tower(SHRINK[part]) for part in PLACES})
        features = 2 * CHANNELS[-1] * len(PLACES)
        self.worn, self.numbers = _head(features, labels), _head(features, numbers)

    def forward(self, rgb8: Tensor) -> tuple[Tensor, Tensor]:
        """(N, labels) log-odds, (N, numbers) of about 0..1."""
        x = rgb8.permute(0, 3, 1, 2).float() / 127.5 - 1
        seen = [
            self.towers[part](x[:, :, top : top + high, left : left + wide])
            for part, (left, top, wide, high) in PLACES.items()
        ]
        joined = torch.cat(seen, 1)
        return self.worn(joined), torch.sigmoid(self.numbers(joined))


def _head(features: int, out: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Dropout(0.3),
        nn.Linear(features, 96),
        nn.ReLU(inplace=True),
        nn.Dropout(0.2),
        nn.Linear(96, out),
    )
