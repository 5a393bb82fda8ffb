"""Writes the reference nets as ONNX, compares them with PyTorch, and lists their hashes.

    python -m makeup_video.training.reference.export runs/lips-lite0.pt runs/eyes-lite0.pt \\
        --out pipeline/weights --expected tests/training/reference_targets.json

A net takes uint8 RGB crops (N, H, W, 3), made by pipeline/reference/crops.py, and returns targets
(N, 7).
"""

import argparse
import json
from pathlib import Path

import torch
from makeup_video.training.faces.checkpoint import averaged_weights, saved_in
from makeup_video.training.faces.export import Exported, to_onnx
from makeup_video.training.inputs import existing
from makeup_video.training.list_hashes import list_hashes
from makeup_video.training.reference.fixed_crops import fixed_crops
from makeup_video.training.reference.model import ReferenceNet


def load(path: Path) -> tuple[str, ReferenceNet]:
    """The region that a checkpoint's net is for, and the net."""
    name, count = saved_in(path)["config"]
    region, size, shrink = name.split("-")
    net = ReferenceNet(size, torch.ones(count), region, int(shrink))
    net.load_state_dict(averaged_weights(path))
    return region, net.eval()


@torch.no_grad()
def targets_of(module: Exported, region: str) -> list[list[float]]:
    """The targets (16, 7) that PyTorch computes from the fixed crops."""
    return module(torch.from_numpy(fixed_crops(region))).round(decimals=5).tolist()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("checkpoints", type=existing, nargs="+")
    parser.add_argument("--out", type=Path, default=Path("runs/weights"))
    parser.add_argument(
        "--expected", type=Path, help="write what PyTorch computes of fixed crops here"
    )
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    expected = {}
    if options.expected and options.expected.exists():  # regions that are not exported now stay
        expected = json.loads(options.expected.read_text())
    for checkpoint in options.checkpoints:
        region, net = load(checkpoint)
        print(f"reference_{region}, of {checkpoint}")
        axes = {key: {0: "n"} for key in ("rgb8", "targets")}
        path, module = options.out / f"reference_{region}.onnx", Exported(net)
        to_onnx(module, path, fixed_crops(region), ["targets"], axes)
        expected[region] = targets_of(module, region)
    if options.expected:
        options.expected.write_text(json.dumps(expected) + "\n")
    list_hashes(options.out)


if __name__ == "__main__":
    main()
