"""The net that tells what is worn: three small towers of convolutions, for eyes, face and lips."""

import torch
from makeup_video.training.worn.crops import PLACES
from torch import Tensor, nn
from torch.nn import functional

CHANNELS = (16, 32, 48, 64)
SHRINK = 2  # of every part: most photos that it learns from are small


class Tower(nn.Sequential):
    """(N, 3, H, W) -> (N, 2 * CHANNELS[-1]): means and maxima of the last features."""

    def __init__(self) -> None:
        layers: list[nn.Module] = []
        before = 3
        for number, channels in enumerate(CHANNELS):
            layers += _block(before, channels, 2)
            if number:
                layers += _block(channels, channels, 1)
            before = channels
        super().__init__(*layers)

    def forward(self, x: Tensor) -> Tensor:
        features = super().forward(functional.avg_pool2d(x, SHRINK))
        return torch.cat([features.mean((2, 3)), features.amax((2, 3))], 1)


def _block(before: int, channels: int, stride: int) -> list[nn.Module]:
    return [
        nn.Conv2d(before, channels, 3, stride, 1, bias=False),
        nn.BatchNorm2d(channels),
        nn.ReLU(inplace=True),
    ]


class WornNet(nn.Module):
    """Pictures of crops, (N, 160, 192, 3) uint8 -> log-odds of each label, (N, labels)."""

    def __init__(self, labels: int) -> None:
        super().__init__()
        self.towers = nn.ModuleDict({part: Tower() for part in PLACES})
        self.head = nn.Sequential(
            nn.Dropout(0.3),
            nn.Linear(2 * CHANNELS[-1] * len(PLACES), 64),
            nn.ReLU(inplace=True),
            nn.Dropout(0.3),
            nn.Linear(64, labels),
        )

    def forward(self, rgb8: Tensor) -> Tensor:
        x = rgb8.permute(0, 3, 1, 2).float() / 127.5 - 1
        seen = [
            self.towers[part](x[:, :, top : top + high, left : left + wide])
            for part, (left, top, wide, high) in PLACES.items()
        ]
        logits: Tensor = self.head(torch.cat(seen, 1))
        return logits
