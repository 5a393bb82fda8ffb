"""A look read from a photo, by nets from any file; and what the nets cost."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import onnxruntime
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.frames.views import RgbPicture
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.regions import REGIONS
from makeup_video.pipeline.reference.correct_colour import second_look
from makeup_video.pipeline.reference.crops import CROPS, numbers_told, read_crop
from makeup_video.pipeline.reference.estimate import photo_light, product_with
from makeup_video.pipeline.render.scene import SceneLight

Net = Callable[[np.ndarray], np.ndarray]  # (N, H, W, 3) uint8 -> (N, 7) targets
_TIMED = 30  # runs


@dataclass(frozen=True)
class Cost:
    """Of one net: megabytes of its weights, ms for one crop by number of threads."""

    megabytes: float
    ms: dict[int, float]


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """A photo, and what the nets are shown of it.  rgb8, crops (by region): (H, W, 3) uint8."""

    rgb8: np.ndarray
    face: Face
    light: SceneLight
    crops: dict[str, np.ndarray]


def file_of(folder: Path, region: str) -> Path | None:
    """A folder's net of a region: exported, or else a checkpoint."""
    exported = folder / f"reference_{region}.onnx"
    found = [exported] if exported.exists() else sorted(folder.glob(f"{region}-*.pt"))
    return found[0] if found else None


def net_of(path: Path, threads: int = 1) -> Net:
    """Of a checkpoint or an exported net."""
    if path.suffix == ".onnx":
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = threads
        run = onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])

        def told(rgb8: np.ndarray) -> np.ndarray:
            targets: np.ndarray = run.run(None, {"rgb8": rgb8})[0]
            return targets

        return told
    import torch
    from makeup_video.training.reference.export import load
    from makeup_video.training.reference.train import estimates

    net = load(path)[1].to(memory_format=torch.channels_last)

    def tell(rgb8: np.ndarray) -> np.ndarray:
        torch.set_num_threads(threads)
        return estimates(net, torch.from_numpy(rgb8)).numpy()

    return tell


def nets_of(folder: Path) -> dict[str, Net]:
    """By region, as far as the folder has them."""
    found = {region: file_of(folder, region) for region in REGIONS}
    return {region: net_of(path) for region, path in found.items() if path}


def cost_of(path: Path, region: str) -> Cost:
    w, h = CROPS[region].size_wh
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
    """Of the net's own numbers: a checkpoint holds the optimizer's too."""
    from makeup_video.training.reference.export import load

    return sum(p.numel() * p.element_size() for p in load(path)[1].parameters())


def cut(rgb8: np.ndarray, face: Face, light: SceneLight) -> Seen:
    """The crops of a face whose points and light are known."""
    picture = RgbPicture(rgb8)
    crops = {region: read_crop(picture, face, region, light) for region in CROPS}
    found = {region: crop for region, crop in crops.items() if crop is not None}
    return Seen(rgb8, face, light, found)


def see(rgb8: np.ndarray) -> Seen | None:
    """The same from the photo alone, its largest face; None when there is none."""
    faces = find_faces(rgb8)
    if not faces:
        return None
    return cut(rgb8, faces[0], photo_light(rgb8, faces[0]))


def look_seen(seen: Seen, nets: Mapping[str, Net], zone: str) -> Look:
    """What the nets tell, as the product takes it: its settings, its second look at the lips."""
    regions = nets.keys() & seen.crops.keys()
    told = {region: numbers_told(nets[region], seen.crops[region]) for region in regions}
    look = look_with(told, zone)
    if look.lips is None:
        return look
    return replace(look, lips=second_look(seen.rgb8, seen.face, seen.light, look.lips))


def look_with(numbers: Mapping[str, np.ndarray], zone: str) -> Look:
    """A look of (7,) numbers by region, and settings of their nearest finishes."""
    parts = {region: product_with(values, region) for region, values in numbers.items()}
    return Look(**parts, zone=zone)


def estimate_look(rgb8: np.ndarray, nets: Mapping[str, Net], zone: str = "lid") -> Look | None:
    """The look of a photo's largest face; None when there is no face."""
    seen = see(rgb8)
    return None if seen is None else look_seen(seen, nets, zone)
