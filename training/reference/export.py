"""Write the reference nets as ONNX, compare with PyTorch, list hashes.

    python -m makeup_video.training.reference.export runs/lips-lite0.pt runs/eyes-lite0.pt --out pipeline/weights

A net takes uint8 RGB crops (N, H, W, 3), as pipeline/reference_io.py cuts them, and gives targets
(N, 7).
"""

import argparse
from pathlib import Path

import numpy as np
import torch
from makeup_video.pipeline.reference_io import CROPS
from makeup_video.training.faces.checkpoint import averaged_weights
from makeup_video.training.faces.export import Exported, list_hashes, to_onnx
from makeup_video.training.reference.model import ReferenceNet


def load(path: Path) -> tuple[str, ReferenceNet]:
    """The region that a checkpoint's net is for, and the net."""
    name, count = torch.load(path, weights_only=True)["config"]
    region, size, shrink = name.split("-")
    net = ReferenceNet(size, torch.ones(count), region, int(shrink))
    net.load_state_dict(averaged_weights(path))
    return region, net.eval()


def examples(region: str) -> np.ndarray:
    """Fixed crops of smooth colours: what both sides must agree on."""
    rng, (w, h) = np.random.default_rng(0), CROPS[region].size_wh
    coarse = rng.integers(0, 256, (16, h // 16, w // 16, 3))
    return coarse.repeat(16, 1).repeat(16, 2).astype(np.uint8)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("checkpoints", type=Path, nargs="+")
    parser.add_argument("--out", type=Path, default=Path("runs/weights"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for checkpoint in options.checkpoints:
        region, net = load(checkpoint)
        print(f"reference_{region}, of {checkpoint}")
        axes = {key: {0: "n"} for key in ("rgb8", "targets")}
        path = options.out / f"reference_{region}.onnx"
        to_onnx(Exported(net), path, examples(region), ["targets"], axes)
    list_hashes(options.out)


if __name__ == "__main__":
    main()
