"""Writes the nets as ONNX, compares them with PyTorch, and lists their hashes.

    python -m makeup_video.training.faces.export --checkpoints runs --out pipeline/weights

Every net takes uint8 RGB crops (N, H, W, 3). If train_quantised.py has written NET_int8.pt beside
NET.pt, that quantised net is exported instead.
"""

import argparse
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import torch
from makeup_video.training.faces.checkpoint import averaged_weights, saved_in
from makeup_video.training.faces.crops import SPECS, Cropper, Faces
from makeup_video.training.faces.detector_pictures import SCENE, Scenes
from makeup_video.training.faces.export_int8 import Integers, chosen, to_integers
from makeup_video.training.faces.fake_quantise import KEPT, rounded, roundings
from makeup_video.training.faces.infer import Net, from_onnx
from makeup_video.training.faces.model import LipNet, build, normalise
from makeup_video.training.faces.train_detector import Detector
from makeup_video.training.inputs import existing, made_by
from makeup_video.training.list_hashes import list_hashes
from torch import Tensor, nn

# Weights are stored as float16: the outputs change by a tenth of a pixel of the crop at most.
TOLERANCE = 2e-3
# A sum half-way between two integers may be rounded either way. The outputs then differ by as much
# as rounding changes them: on average by less than this share of the largest value.
INTEGERS_TOLERANCE = 1e-2
OUTPUTS = {
    "mesh": ["points", "scores"],
    "lips": ["points", "mask_logits"],
    "eye": ["points"],
    "detector": ["cells"],
}


class Exported(nn.Module):
    """uint8 crops -> the outputs asked for, scores as probabilities."""

    def __init__(self, net: nn.Module, outputs: tuple[str, ...] = ()) -> None:
        super().__init__()
        self.net, self.outputs = net, outputs

    def forward(self, rgb8: Tensor) -> tuple[Tensor, ...] | Tensor:
        out = self.net(normalise(rgb8))
        return out if isinstance(out, Tensor) else chosen(out, self.outputs)


def load(path: Path) -> tuple[str, nn.Module]:
    """The name of a checkpoint's net, and the net with averaged weights."""
    saved = saved_in(path)
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
    print(f"{path}: step {saved_in(path)['step']}")

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


def load_rounded(source: Path, integers: Path) -> nn.Module:
    """The quantised net that train_quantised.py wrote beside a checkpoint."""
    name, net = load(source)
    net = rounded(net, KEPT.get(name, ()))
    net.load_state_dict(saved_in(integers))
    for rounding in roundings(net):
        rounding.observing = False
    return net.eval()


def quantised(source: Path) -> Path | None:
    """The file of the quantised net beside a checkpoint, if any; stop if it is older than that."""
    integers = source.with_name(f"{source.stem}_int8.pt")
    if not source.exists() or not integers.exists():
        return None
    if integers.stat().st_mtime < source.stat().st_mtime:
        raise SystemExit(
            f"{integers} is older than {source}, and would be written in its place: run "
            f"train_quantised {source.stem} again, or move it away"
        )
    return integers


def folded(net: nn.Module) -> nn.Module:
    """The same net, changed in place to plain convolutions alone, which from_onnx.py can read."""
    if isinstance(net, LipNet):
        net.paint[0] = net.paint[0].as_conv()
    return net


def write(name: str, source: Path, path: Path, crops: np.ndarray) -> None:
    """Write the net of a checkpoint, in integers if there is a quantised net beside it."""
    axes = {key: {0: "n"} for key in ("rgb8", *OUTPUTS[name])}
    if name == "detector":
        axes = {"rgb8": {0: "n", 1: "h", 2: "w"}, "cells": {0: "n", 2: "rows", 3: "columns"}}
    integers = quantised(source)
    if integers:
        module = Integers(folded(load_rounded(source, integers)), OUTPUTS[name])
        to_onnx(module, path, crops, OUTPUTS[name], axes, True, KEPT.get(name, ()))
    else:
        to_onnx(Exported(folded(load(source)[1]), OUTPUTS[name]), path, crops, OUTPUTS[name], axes)


def to_onnx(
    module: nn.Module,
    path: Path,
    crops: np.ndarray,
    outputs: list[str],
    axes: dict[str, dict[int, str]],
    in_integers: bool = False,
    kept: tuple[str, ...] = (),
) -> None:
    """Write a module that takes uint8 crops. If ONNX Runtime's outputs differ, stop and leave the
    file as it was.

    kept: parts of the module's net that stay float when the rest becomes integers.
    """
    target, path = path, path.with_name(f"{path.stem}.part.onnx")
    module.eval()
    rgb8 = torch.from_numpy(crops[:1])
    torch.onnx.export(module, (rgb8,), str(path), dynamo=False, opset_version=17,
                      input_names=["rgb8"], output_names=outputs, dynamic_axes=axes)  # fmt: skip
    if in_integers:
        to_integers(path, kept)
        fuse(path)
    if kept or not in_integers:
        halve(path)
    with torch.no_grad():
        wanted = module(torch.from_numpy(crops[:16]))
    wanted = (wanted,) if isinstance(wanted, Tensor) else wanted
    got = from_onnx(path)(crops[:16])
    for key, a, b in zip(outputs, wanted, got, strict=True):
        off, most = np.abs(a.numpy() - b), max(1, float(a.abs().max()))
        print(f"  {key}: difference {off.mean():.1e}, worst {off.max():.1e}")
        if off.mean() > INTEGERS_TOLERANCE * most if in_integers else off.max() > TOLERANCE * most:
            path.unlink()
            raise SystemExit(f"{target.name}: ONNX Runtime and PyTorch disagree in {key}")
    path.replace(target)


def fuse(path: Path) -> None:
    """Apply the fusions on which ONNX Runtime would spend half of its loading time at every start.

    The level is extended: fusions that depend on the processor are left for the start.
    """
    options = onnxruntime.SessionOptions()
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_EXTENDED
    options.optimized_model_filepath = str(path)
    options.log_severity_level = 3  # hides warnings about unused constants that torch wrote
    providers = ["CPUExecutionProvider"]
    onnxruntime.InferenceSession(path.read_bytes(), options, providers=providers)


def halve(path: Path) -> None:
    """Store the weights as float16; ONNX Runtime converts them back once, when it loads them."""
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--checkpoints", type=existing, default="runs")
    parser.add_argument("--data", type=made_by("faces.prepare"), default="runs/faces.npz")
    parser.add_argument("--out", type=Path, default=Path("pipeline/weights"))
    options = parser.parse_args()
    sources = {name: options.checkpoints / f"{name}.pt" for name in OUTPUTS}
    for source in sources.values():  # before anything is written
        quantised(source)
    options.out.mkdir(parents=True, exist_ok=True)
    packed = np.load(options.data)
    np.save(options.out / "mean_face.npy", packed["mean"])  # (478, 3) in IOD
    np.save(options.out / "mirror.npy", packed["mirror"].astype(np.int16))
    for name, source in sources.items():
        path = options.out / f"{name}.onnx"
        if not source.exists():
            print(f"{source} is missing: left out")
            continue
        print(name)
        crops = examples(name, options.data, 200 if name != "detector" else 60)
        assert crops.shape[1:3] == ((SCENE, SCENE) if name == "detector"
                                    else SPECS[name].size_wh[::-1])  # fmt: skip
        write(name, source, path, crops)
    list_hashes(options.out)


if __name__ == "__main__":
    main()
