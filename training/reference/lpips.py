"""LPIPS (Zhang et al., 2018), version 0.1 with AlexNet, with weights from files.

Needs torchvision's AlexNet and the linear heads of github.com/richzhang/PerceptualSimilarity,
lpips/weights/v0.1/alex.pth: two files, or one that holds both.
"""

import re
from collections.abc import Sequence
from pathlib import Path

import torch
from torch import Tensor, nn

# For inputs in -1..1, so that AlexNet gets pictures with ImageNet's mean and deviation.
_SHIFT, _SCALE = (-0.030, -0.088, -0.188), (0.458, 0.448, 0.450)
# Index into AlexNet's features, inputs, outputs, kernel, stride, padding. Pools come before the
# second and the third.
_CONVS = (
    (0, 3, 64, 11, 4, 2), (3, 64, 192, 5, 1, 2), (6, 192, 384, 3, 1, 1),
    (8, 384, 256, 3, 1, 1), (10, 256, 256, 3, 1, 1),
)  # fmt: skip
_POOLED = (3, 6)
_CONV_KEY = re.compile(r"(?:features|slice\d)\.(\d+)\.(weight|bias)$")
_HEAD_KEY = re.compile(r"lin(\d)\.model\.1\.weight$")


class Lpips(nn.Module):
    """Two batches (N, 3, H, W) in 0..1 -> (N,) perceptual distances, 0 for the same."""

    def __init__(self) -> None:
        super().__init__()
        self.convs = nn.ModuleDict({
            str(at): nn.Conv2d(inputs, outputs, kernel, stride, padding)
            for at, inputs, outputs, kernel, stride, padding in _CONVS
        })  # fmt: skip
        heads = [nn.Conv2d(conv[2], 1, 1, bias=False) for conv in _CONVS]
        self.heads = nn.ModuleDict({str(at): head for at, head in enumerate(heads)})
        self.register_buffer("shift", torch.tensor(_SHIFT)[:, None, None], persistent=False)
        self.register_buffer("scale", torch.tensor(_SCALE)[:, None, None], persistent=False)

    def features(self, x: Tensor) -> list[Tensor]:
        """The features of each layer, (N, C, h, w), scaled to length 1 along C."""
        x, found = (2 * x - 1 - self.shift) / self.scale, []
        for at, conv in self.convs.items():
            x = nn.functional.max_pool2d(x, 3, 2) if int(at) in _POOLED else x
            x = torch.relu(conv(x))
            found.append(x / (x.square().sum(1, keepdim=True).sqrt() + 1e-10))
        return found

    @torch.no_grad()
    def forward(self, a: Tensor, b: Tensor) -> Tensor:
        pairs = zip(self.heads.values(), self.features(a), self.features(b), strict=True)
        return sum(head((p - q).square()).mean((1, 2, 3)) for head, p, q in pairs)


def load(paths: Sequence[Path]) -> Lpips:
    """Loads LPIPS. Raises ValueError when the files do not hold all weights."""
    ours = {}
    for path in paths:
        for key, value in torch.load(path, map_location="cpu", weights_only=True).items():
            if found := _CONV_KEY.search(key):
                ours[f"convs.{found[1]}.{found[2]}"] = value
            elif found := _HEAD_KEY.search(key):
                ours[f"heads.{found[1]}.weight"] = value
    net = Lpips()
    if missing := net.state_dict().keys() - ours.keys():
        raise ValueError(f"LPIPS weights lack {', '.join(sorted(missing))}: give AlexNet and heads")
    net.load_state_dict(ours)
    return net.eval()
