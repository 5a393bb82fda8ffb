"""Reads a look from a photo with nets from any file, and measures size and speed of the nets."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.frames.views import RgbPicture
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.reference.crops import CROPPED, CROPS, read_input, read_numbers
from makeup_video.pipeline.reference.estimate import product_with
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.render.scene import SceneLight
from makeup_video.training.faces.infer import from_onnx

Net = Callable[[np.ndarray], np.ndarray]  # (N, H, W, 3) uint8 -> (N, 7) targets
_TIMED = 30  # runs


@dataclass(frozen=True)
class Cost:
    """What a net costs: megabytes of weights, and ms for one crop by number of threads."""

    megabytes: float
    ms: dict[int, float]


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """A photo, its face and light, and the inputs of the nets.

    rgb8: (H, W, 3) uint8. crops: by region, (H, W, 3) uint8.
    """

    rgb8: np.ndarray
    face: Face
    light: SceneLight
    crops: dict[str, np.ndarray]


def file_of(folder: Path, region: str) -> Path | None:
    """The net of a region in a folder: the exported file, else a checkpoint, else None.

    Raises ValueError where a region has several checkpoints.
    """
    exported = folder / f"reference_{region}.onnx"
    found = [exported] if exported.exists() else sorted(folder.glob(f"{region}-*.pt"))
    if len(found) > 1:
        raise ValueError(
            f"{folder}: expected one checkpoint for {region}, got "
            f"{', '.join(path.name for path in found)}: move the others to another folder"
        )
    return found[0] if found else None


def net_of(path: Path, threads: int = 1) -> Net:
    """Loads a net from a checkpoint or an exported file."""
    if path.suffix == ".onnx":
        run = from_onnx(path, threads)
        return lambda rgb8: run(rgb8)[0]
    import torch
    from makeup_video.training.reference.export import load
    from makeup_video.training.reference.train import estimates

    net = load(path)[1].to(memory_format=torch.channels_last)

    def from_checkpoint(rgb8: np.ndarray) -> np.ndarray:
        torch.set_num_threads(threads)
        return estimates(net, torch.from_numpy(rgb8)).numpy()

    return from_checkpoint


def nets_of(folder: str | Path) -> dict[str, Net]:
    """The nets of a folder by region; a region without a net is left out."""
    folder = Path(folder)
    found = {region: file_of(folder, region) for region in CROPPED}
    return {region: net_of(path) for region, path in found.items() if path}


def cost_of(path: Path, region: str) -> Cost:
    """The cost of a net, measured on a grey crop."""
    w, h = CROPS[region].input_wh
    crop, ms = np.full((1, h, w, 3), 128, np.uint8), {}
    for threads in (1, 2):
        net, took = net_of(path, threads), []
        for _ in range(_TIMED + 5):
            began = time.perf_counter()
            net(crop)
            took.append(time.perf_counter() - began)
        ms[threads] = 1e3 * float(np.median(took[5:]))
    size = path.stat().st_size if path.suffix == ".onnx" else _checkpoint_bytes(path)
    return Cost(size / 1e6, ms)


def _checkpoint_bytes(path: Path) -> int:
    """The size of the net's own weights: a checkpoint holds the optimizer's state, too."""
    from makeup_video.training.reference.export import load

    return sum(p.numel() * p.element_size() for p in load(path)[1].parameters())


def cut(rgb8: np.ndarray, face: Face, light: SceneLight) -> Seen:
    """The inputs of the nets from a face whose points and light are known."""
    picture = RgbPicture(rgb8)
    crops = {region: read_input(picture, face, region, light) for region in CROPS}
    found = {region: crop for region, crop in crops.items() if crop is not None}
    return Seen(rgb8, face, light, found)


def see(rgb8: np.ndarray) -> Seen | None:
    """The inputs of the nets from the largest face of a photo; None when there is no face."""
    faces = find_faces(rgb8)
    if not faces:
        return None
    return cut(rgb8, faces[0], photo_light(rgb8, faces[0]))


def look_seen(seen: Seen, nets: Mapping[str, Net], zone: str) -> Look:
    """The look as the nets read it."""
    regions = nets.keys() & seen.crops.keys()
    numbers = {region: read_numbers(nets[region], seen.crops[region]) for region in regions}
    return look_with(numbers, zone)


def look_with(numbers: Mapping[str, np.ndarray], zone: str) -> Look:
    """A look of (7,) numbers by region, with the settings of the nearest finishes."""
    parts = {region: product_with(values, region) for region, values in numbers.items()}
    return Look(**parts, **({"zone": zone} if "eyes" in parts else {}))


def paper_look(rgb8: np.ndarray, nets: Mapping[str, Net], zone: str = "lid") -> Look | None:
    """The look of a photo's largest face as the paper reads it: by these nets alone.

    rgb8: (H, W, 3) uint8, sRGB. nets: see nets_of. zone: where the eyeshadow lies, which no net
    reads. None when there is no face. pipeline/reference/estimate.py has the product's own reading.
    Raises ValueError without any net, since such a look would be bare.
    """
    if not nets:
        raise ValueError("nets must hold one of lips or eyes, got none: give a folder with nets")
    seen = see(rgb8)
    return None if seen is None else look_seen(seen, nets, zone)
