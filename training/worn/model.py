"""The net that reads what is worn: three small towers of convolutions, for eyes, face and lips."""

import torch
from makeup_video.pipeline.reference.makeup_input import PLACES
from torch import Tensor, nn
from torch.nn import functional

# Channels of each stage: of the shipped net, and of its teachers.
CHANNELS = {"small": (16, 32, 48, 64, 64), "large": (32, 64, 96, 128, 128)}
# The factor by which each part is shrunk first. Most training photos are small, so the small net
# loses little. But a line along the lashes is thin, so the eyes keep their size.
SHRINK = {
    "small": {"eyes": 1, "face": 2, "lips": 2},
    "large": {"eyes": 1, "face": 1, "lips": 1},
}


class Tower(nn.Sequential):
    """(N, 3, H, W) -> (N, 2 * channels[-1]): means and maxima of the last features."""

    def __init__(self, channels: tuple[int, ...], shrink: int) -> None:
        """channels: of each stage.  shrink: the factor by which the input is shrunk first."""
        layers: list[nn.Module] = []
        before = 3
        for number, here in enumerate(channels[: len(channels) - shrink + 1]):
            layers += _block(before, here, 2)
            if number:
                layers += _block(here, here, 1)
            before = here
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
    """Inputs (N, 160, 192, 3) uint8 -> log-odds of each kind of makeup, and numbers of the look."""

    def __init__(self, labels: int, numbers: int, size: str = "small") -> None:
        """size: one of CHANNELS."""
        super().__init__()
        channels, shrink = CHANNELS[size], SHRINK[size]
        self.towers = nn.ModuleDict({part: Tower(channels, shrink[part]) for part in PLACES})
        features = 2 * len(PLACES) * channels[-1]
        self.worn, self.numbers = _head(features, labels), _head(features, numbers)

    def forward(self, rgb8: Tensor) -> tuple[Tensor, Tensor]:
        """(N, labels) log-odds, and (N, numbers) in 0..1."""
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
