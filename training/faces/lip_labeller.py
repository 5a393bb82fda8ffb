"""The labeller of lip masks: a small U-Net that sees a mouth and the evidence of lip_evidence.py.

The labeller is fitted to the mouths outlined by hand. Unlike the product's net it may be slow, sees
more than the picture, and need not withstand bad light: it only carries the outlines over to other
faces of the training pictures.
"""

from typing import NamedTuple

import numpy as np
import torch
from makeup_video.training.faces.lip_evidence import MASK_SPEC
from makeup_video.training.faces.model import Conv
from makeup_video.training.faces.train import cross_entropy_of
from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

WINDOW = np.s_[16:128, 24:168]  # rows and columns of a mask crop that the net sees
CHANNELS = 32
EPOCHS, BATCH, RATE, WARM_UP = 36, 16, 3e-3, 50
AVERAGE = 0.99  # of the weights, per step
COVERED = 0.1  # a px counts as hidden if a hand or hair covers at least this share of it
# Augmentation, one sigma: log gain of all colours and of each; noise of a whole feature and of its
# px, in deviations; log scale, turn (radians) and shift (in half windows). The last number is how
# often a feature is left out.
GAINS, NOISE, MOVED, LEFT_OUT = (0.2, 0.06), (0.15, 0.1), (0.1, 0.12, 0.06), 0.08


class Labels(NamedTuple):
    """The targets of mouths: mouth, opening and teeth (N, 3, H, W), as in Mouth.shares, and whether
    they are known (N, H, W)."""

    shares: Tensor
    known: Tensor


class Labeller(nn.Module):
    """RGB and features (N, 3 + F, 112, 144) -> log-odds (N, 3, 112, 144) of the whole mouth, of the
    opening, and of teeth in the opening."""

    def __init__(self, inputs: int) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(inputs, 1, 1))
        self.register_buffer("deviation", torch.ones(inputs, 1, 1))
        one, two, three = CHANNELS, 2 * CHANNELS, 3 * CHANNELS
        self.fine, self.finer = Conv(inputs, one, 2), nn.Sequential(Conv(one, one), Conv(one, one))
        self.coarse = nn.Sequential(Conv(one, two, 2), Conv(two, two))
        self.coarser = nn.Sequential(Conv(two, three, 2), Conv(three, three), nn.Dropout2d(0.1))
        self.up = nn.Upsample(scale_factor=2, mode="bilinear")
        self.narrow = nn.ModuleList([nn.Conv2d(three, two, 1), nn.Conv2d(two, one, 1)])
        self.merge = nn.ModuleList([Conv(two, two), nn.Sequential(Conv(one, one), Conv(one, one))])
        self.head = nn.Sequential(nn.Conv2d(one, 12, 1), nn.PixelShuffle(2))

    def scale(self, inputs: Tensor) -> None:
        """Set the means and the deviations of the features from all inputs (N, 3 + F, H, W)."""
        self.mean[3:, 0, 0] = inputs[:, 3:].mean((0, 2, 3))
        self.deviation[3:, 0, 0] = inputs[:, 3:].std((0, 2, 3)) + 1e-3

    def forward(self, x: Tensor) -> Tensor:
        fine = self.fine((x - self.mean) / self.deviation)
        fine = fine + self.finer(fine)
        coarse = self.coarse(fine)
        coarse = self.merge[0](self.up(self.narrow[0](self.coarser(coarse))) + coarse)
        return self.head(self.merge[1](self.up(self.narrow[1](coarse)) + fine))


def to_input(features: np.ndarray, crop: np.ndarray) -> np.ndarray:
    """Features (144, 192, F) and mask crop (144, 192, 3) -> (3 + F, 112, 144) float32."""
    colours = crop[WINDOW].astype(np.float32) / 127.5 - 1
    return np.concatenate([colours, features[WINDOW]], -1, dtype=np.float32).transpose(2, 0, 1)


def to_labels(shares: np.ndarray, covered: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mouth.shares (144, 192, 3) and Mouth.covered (144, 192) -> as in Labels, for one mouth."""
    return shares[WINDOW].transpose(2, 0, 1), (covered[WINDOW] < COVERED).astype(np.float32)


def fit(inputs: np.ndarray, labels: Labels, seed: int = 0) -> Labeller:
    """Fit a labeller to mouths. inputs: (N, 3 + F, 112, 144) float32, made by to_input."""
    torch.manual_seed(seed)
    rng, seen = np.random.default_rng(seed), torch.from_numpy(inputs)
    net = Labeller(seen.shape[1]).to(memory_format=torch.channels_last)
    net.scale(seen)
    average = AveragedModel(net, multi_avg_fn=get_ema_multi_avg_fn(AVERAGE), use_buffers=True)
    optimizer = torch.optim.AdamW(net.parameters(), lr=RATE, weight_decay=0.05)
    steps = EPOCHS * len(inputs) // BATCH
    for step in range(steps):
        for group in optimizer.param_groups:
            group["lr"] = RATE * min(1, (step + 1) / WARM_UP, 1.6 * (1 - step / steps) + 0.005)
        chosen = rng.integers(0, len(inputs), BATCH)
        mouths = Labels(labels.shares[chosen], labels.known[chosen])
        x, mouths = augmented(seen[chosen], mouths, net, rng)
        loss = cross_entropy_of(net(x.contiguous(memory_format=torch.channels_last)), *mouths)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        average.update_parameters(net)
        if step % 100 == 0:
            print(f"labeller, step {step}/{steps}, loss {loss.item():.3f}", flush=True)
    return average.module.eval()


def augmented(
    x: Tensor, labels: Labels, net: Labeller, rng: np.random.Generator
) -> tuple[Tensor, Labels]:
    """The same mouths mirrored, moved, in other light, with worse evidence."""
    count, features = len(x), x.shape[1] - 3
    mirrored = rng.random(count) < 0.5
    x, shares, known = (
        torch.where(torch.from_numpy(mirrored).view(-1, *[1] * (t.ndim - 1)), t.flip(-1), t)
        for t in (x, *labels)
    )
    gain = rng.normal(0, GAINS[0], (count, 1, 1, 1)) + rng.normal(0, GAINS[1], (count, 3, 1, 1))
    colours = ((x[:, :3] + 1) * torch.from_numpy(np.exp(gain)).float() - 1).clamp(-1, 1)
    noise = NOISE[0] * torch.randn(count, features, 1, 1) + NOISE[1] * torch.randn_like(x[:, 3:])
    evidence = x[:, 3:] + noise * net.deviation[3:]
    left_out = torch.rand(count, features, 1, 1) < LEFT_OUT
    x = torch.cat([colours, torch.where(left_out, net.mean[3:], evidence)], 1)
    scale, turn = np.exp(rng.normal(0, MOVED[0], count)), rng.normal(0, MOVED[1], count)
    high, wide = x.shape[2:]
    across, down = scale * np.cos(turn), scale * np.sin(turn)
    to_source = np.stack([
        np.stack([across, -down * high / wide, rng.normal(0, MOVED[2], count)], -1),
        np.stack([down * wide / high, across, rng.normal(0, MOVED[2], count)], -1),
    ], 1)  # fmt: skip
    places = nn.functional.affine_grid(
        torch.from_numpy(to_source).float(), list(x.shape), align_corners=False
    )

    def drawn(t: Tensor) -> Tensor:
        return nn.functional.grid_sample(t, places, padding_mode="border", align_corners=False)

    return drawn(x), Labels(drawn(shares), drawn(known[:, None])[:, 0])


@torch.no_grad()
def label(labeller: Labeller, features: np.ndarray, crop: np.ndarray) -> tuple[np.ndarray, float]:
    """Whole mouth, opening and teeth (144, 192, 3) uint8, and the mean certainty, 0 to 1."""
    x = torch.from_numpy(to_input(features, crop))[None]
    found = (labeller(x) + labeller(x.flip(-1)).flip(-1))[0] / 2
    weight = np.zeros((*MASK_SPEC.size_wh[::-1], 3), np.float32)
    weight[WINDOW] = found.sigmoid().numpy().transpose(1, 2, 0)
    lips = weight[..., 0] * (1 - weight[..., 1])
    sure = np.square(2 * lips - 1)[lips > 0.1].mean() if lips.max() > 0.5 else 0.0
    return np.rint(weight * 255).astype(np.uint8), float(sure)
