"""Write the nets as ONNX, compare both outputs, list hashes.

    python -m makeup_video.training.faces.export --checkpoints runs --out pipeline/weights

Every net takes uint8 RGB crops (N, H, W, 3). Convolutions can be turned to int8
(--int8 NET ...), calibrated on training crops.
"""

import argparse
import hashlib
import json
from pathlib import Path

import numpy as np
import onnx
import torch
from makeup_video.training.faces.checkpoint import averaged_weights
from makeup_video.training.faces.crops import SPECS, Cropper, Faces
from makeup_video.training.faces.detect import Detector
from makeup_video.training.faces.infer import Net, from_onnx
from makeup_video.training.faces.model import build, normalise
from makeup_video.training.faces.scenes import SCENE, Scenes
from onnxruntime.quantization import CalibrationDataReader, QuantFormat, QuantType, quantize_static
from onnxruntime.quantization.shape_inference import quant_pre_process
from torch import Tensor, nn

# Weights are kept as float16: a tenth of a pixel of the crop at most.
TOLERANCE = 2e-3
OUTPUTS = {
    "mesh": ["points", "scores"],
    "lips": ["points", "scores", "mask_logits"],
    "eye": ["points", "scores"],
    "detector": ["cells"],
}


class Exported(nn.Module):
    """uint8 crops in; scores out as probabilities."""

    def __init__(self, net: nn.Module) -> None:
        super().__init__()
        self.net = net

    def forward(self, rgb8: Tensor) -> tuple[Tensor, ...] | Tensor:
        out = self.net(normalise(rgb8))
        if isinstance(out, Tensor):
            return out
        points, logits, *rest = out
        return (points, logits.sigmoid(), *rest)


def load(path: Path) -> tuple[str, nn.Module]:
    saved = torch.load(path, weights_only=True)
    name, count = saved["config"]
    if name == "detector":
        net: nn.Module = Detector()
    else:
        net = build(name, SPECS[name].size_wh, torch.zeros(200, count, 3))
    net.load_state_dict(averaged_weights(path))
    return name, net.eval()


def from_checkpoint(path: Path) -> Net:
    """The averaged weights of a checkpoint as a function of uint8 crops."""
    _name, net = load(path)
    print(f"{path}: step {torch.load(path, weights_only=True)['step']}")

    def run(rgb8: np.ndarray) -> tuple[np.ndarray, ...]:
        with torch.no_grad():
            out = net(normalise(torch.from_numpy(rgb8)))
        return (out.numpy(),) if isinstance(out, Tensor) else tuple(o.numpy() for o in out)

    return run


def examples(name: str, data: Path, count: int) -> np.ndarray:
    faces = Faces(data, False)
    if name == "detector":
        scenes = Scenes(faces, seed=7)
        return np.stack([scenes.draw()[0] for _ in range(count)])
    return Cropper(faces, SPECS[name], seed=7).batch(count).rgb8


def write(name: str, net: nn.Module, path: Path, crops: np.ndarray) -> None:
    axes = {key: {0: "n"} for key in ("rgb8", *OUTPUTS[name])}
    if name == "detector":
        axes = {"rgb8": {0: "n", 1: "h", 2: "w"}, "cells": {0: "n", 2: "rows", 3: "columns"}}
    to_onnx(Exported(net), path, crops, OUTPUTS[name], axes)


def to_onnx(
    module: nn.Module,
    path: Path,
    crops: np.ndarray,
    outputs: list[str],
    axes: dict[str, dict[int, str]],
) -> None:
    """Write a module of uint8 crops, and stop when ONNX Runtime gives something else."""
    module.eval()
    rgb8 = torch.from_numpy(crops[:1])
    torch.onnx.export(module, (rgb8,), str(path), dynamo=False, opset_version=17,
                      input_names=["rgb8"], output_names=outputs, dynamic_axes=axes)  # fmt: skip
    halve(path)
    with torch.no_grad():
        wanted = module(torch.from_numpy(crops[:16]))
    wanted = (wanted,) if isinstance(wanted, Tensor) else wanted
    got = from_onnx(path)(crops[:16])
    for key, a, b in zip(outputs, wanted, got, strict=True):
        worst = float(np.abs(a.numpy() - b).max())
        print(f"  {key}: worst difference {worst:.1e}")
        if worst > TOLERANCE * max(1, float(a.abs().max())):
            raise SystemExit(f"{path.name}: ONNX Runtime and PyTorch disagree in {key}")


def list_hashes(folder: Path) -> None:
    """Write sha256.json, which the product checks its weights by; tell how large they are."""
    files = sorted(folder.glob("*.onnx")) + sorted(folder.glob("*.npy"))
    hashes = {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}
    (folder / "sha256.json").write_text(json.dumps(hashes, indent=2) + "\n")
    print(f"{sum(file.stat().st_size for file in files) / 1e6:.2f} MB in all")


def halve(path: Path) -> None:
    """Keep the weights as float16; ONNX Runtime turns them back once, when it loads them."""
    model = onnx.load(path)
    casts = []
    for tensor in model.graph.initializer:
        if tensor.data_type != onnx.TensorProto.FLOAT or np.prod(tensor.dims) < 1000:
            continue
        values = onnx.numpy_helper.to_array(tensor).astype(np.float16)
        name = tensor.name
        tensor.CopyFrom(onnx.numpy_helper.from_array(values, f"{name}_half"))
        casts.append(onnx.helper.make_node("Cast", [f"{name}_half"], [name], to=1))
    for cast in reversed(casts):
        model.graph.node.insert(0, cast)
    onnx.checker.check_model(model)
    onnx.save(model, path)


class Crops(CalibrationDataReader):
    def __init__(self, crops: np.ndarray) -> None:
        self.left = iter(crops)

    def get_next(self) -> dict[str, np.ndarray] | None:
        crop = next(self.left, None)
        return None if crop is None else {"rgb8": crop[None]}


def quantize(path: Path, crops: np.ndarray) -> None:
    """Convolutions to int8, weights per channel; the heads stay float."""
    before = from_onnx(path)(crops)
    part = path.with_suffix(".part")
    quant_pre_process(str(path), str(part), skip_symbolic_shape=True)
    quantize_static(
        str(part), str(path), Crops(crops), quant_format=QuantFormat.QDQ, per_channel=True,
        activation_type=QuantType.QUInt8, weight_type=QuantType.QInt8,
        op_types_to_quantize=["Conv", "Add", "Resize"],
    )  # fmt: skip
    part.unlink()
    after = from_onnx(path)(crops)
    off = np.linalg.norm((before[0] - after[0])[..., :2], axis=-1).mean()
    print(f"  int8 moves the first output by {off:.5f} on average")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--checkpoints", type=Path, default=Path("runs"))
    parser.add_argument("--data", type=Path, default=Path("runs/faces.npz"))
    parser.add_argument("--out", type=Path, default=Path("pipeline/weights"))
    parser.add_argument("--int8", nargs="*", default=[], choices=list(OUTPUTS))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    packed = np.load(options.data)
    np.save(options.out / "mean_face.npy", packed["mean"])  # (478, 3) in IOD: the face frame
    np.save(options.out / "mirror.npy", packed["mirror"].astype(np.int16))
    for name in OUTPUTS:
        source, path = options.checkpoints / f"{name}.pt", options.out / f"{name}.onnx"
        if not source.exists():
            print(f"{source} is missing: left out")
            continue
        print(name)
        crops = examples(name, options.data, 200 if name != "detector" else 60)
        assert crops.shape[1:3] == ((SCENE, SCENE) if name == "detector"
                                    else SPECS[name].size_wh[::-1])  # fmt: skip
        write(name, load(source)[1], path, crops)
        if name in options.int8:
            quantize(path, crops)
    list_hashes(options.out)


if __name__ == "__main__":
    main()
