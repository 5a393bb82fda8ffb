"""Draws training crops: turned in depth, misplaced as by a tracker, badly lit, half hidden."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import PATCH_SPAN
from makeup_video.pipeline.faces.topology import EYE, LIPS, LIPS_INNER, LIPS_OUTER
from makeup_video.training.faces.augment import Occluder, harsh, photograph, restyle
from makeup_video.training.faces.contour import fill
from makeup_video.training.faces.openings import Openings
from makeup_video.training.faces.prepare import DEPTH_REACH, FOLDERS

MASK_FOLDERS, MASK_SPAN = ("portraits", "talking", "wild", "sharp"), 1.4  # of lip_masks.py; IOD
MASK_CERTAINTY = 0.44  # the least: leaves out a sixteenth of `wild`, and hardly any other mask
OUTLINED = 8.0  # how many times as often as another a mouth outlined by hand is drawn
HARSH = 0.45  # share of lip crops with light and colours that spoil the border
LOWER_FACE = 0.55  # IOD below the eyes: what a medical mask may hide
PIVOT = np.array([0, 0.35])  # IOD below the eyes: the head's centre, about which it turns
LIPS_AT = {int(point): at for at, point in enumerate(LIPS)}


@dataclass(frozen=True)
class CropSpec:
    """A net's input, which is a crop turned with the face, and the points that the net reads."""

    size_wh: tuple[int, int]  # px
    span: float  # width of the crop, in IOD
    points: np.ndarray  # indices into the 478
    around: np.ndarray | None  # the crop's centre is the mean of these points; None: `centre`
    centre: tuple[float, float] = (0.0, 0.0)
    # Error of the tracker, one sigma: turn (radians), log scale, shift (IOD).
    jitter: tuple[float, float, float] = (0.08, 0.06, 0.06)
    turn: tuple[float, float] = (0.28, 0.16)  # turn in depth, one sigma: yaw, pitch (radians)
    share: dict[str, float] = field(  # how often each folder is drawn
        default_factory=lambda: {"portraits": 0.25, "wild": 0.52, "talking": 0.18, "covered": 0.05}
    )


SPECS = {
    "mesh": CropSpec((96, 96), 2.56, np.arange(478), None, (0.0, 0.42)),
    "lips": CropSpec(
        (112, 80), PATCH_SPAN, LIPS, LIPS, jitter=(0.06, 0.06, 0.04), turn=(0.36, 0.2),
        share={"portraits": 0.4, "wild": 0.28, "talking": 0.22, "sharp": 0.1, "covered": 0.0},
    ),
    "eye": CropSpec(
        (64, 48), 0.72, EYE, EYE[:16], jitter=(0.06, 0.06, 0.03),
        share={"portraits": 0.3, "wild": 0.45, "talking": 0.22, "covered": 0.03},
    ),
}  # fmt: skip


class Faces:
    """The packed faces of one split."""

    def __init__(self, path: Path, validation: bool) -> None:
        packed = np.load(path)
        self.mean, self.mirror = packed["mean"], packed["mirror"]
        self.pictures: list[list[np.ndarray]] = []  # per face: full size, then halved repeatedly
        columns: dict[str, list[np.ndarray]] = {"frames": [], "face_points": [], "depth": []}
        folders, sources = [], []
        for name in FOLDERS:
            chosen = packed[f"{name}_validation"] == validation
            for rgb8 in packed[f"{name}_rgb8"][chosen]:
                levels = [rgb8]
                while len(levels[-1]) > 200:
                    half = len(levels[-1]) // 2
                    levels.append(
                        cv2.resize(levels[-1], (half, half), interpolation=cv2.INTER_AREA)
                    )
                self.pictures.append(levels)
            for key, parts in columns.items():
                parts.append(packed[f"{name}_{key}"][chosen])
            folders += [name] * int(chosen.sum())
            sources += list(packed[f"{name}_source"][chosen])
        self.folder, self.source = np.array(folders), np.array(sources)
        self.poses = np.concatenate(columns["frames"])
        self.points = np.concatenate(columns["face_points"])
        self.depth = np.concatenate(columns["depth"])
        self.rarity = self._rarity()
        self.masks: dict[int, tuple[np.ndarray, np.ndarray]] = {}  # face -> mask, its map to px
        self.outlined = np.zeros(len(self.pictures), bool)
        if path.with_name("lipmasks.npz").exists():
            self._read_masks(path.with_name("lipmasks.npz"), packed, validation)

    def _read_masks(self, path: Path, packed: np.lib.npyio.NpzFile, validation: bool) -> None:
        masks = np.load(path)
        for name in MASK_FOLDERS:
            chosen = packed[f"{name}_validation"] == validation
            columns = (masks[f"{name}_{key}"][chosen] for key in ("masks", "windows", "sure"))
            faces = np.flatnonzero(self.folder == name)
            self.outlined[faces] = masks[f"{name}_outlined"][chosen]
            for face, mask, to_px, sure in zip(faces, *columns, strict=True):
                if sure > MASK_CERTAINTY:
                    self.masks[int(face)] = mask, to_px

    def _rarity(self) -> np.ndarray:
        """Sampling weights that even out how light the tip of the nose is (at most 5 to 1)."""
        luma = np.empty(len(self.pictures))
        for i, (levels, pose) in enumerate(zip(self.pictures, self.poses, strict=True)):
            x, y = pose[:, :2] @ np.array([0.0, 0.45]) + pose[:, 2]
            size = len(levels[0]) - 1
            x, y = int(np.clip(x, 0, size)), int(np.clip(y, 0, size))
            luma[i] = levels[0][max(y - 3, 0) : y + 4, max(x - 3, 0) : x + 4].mean()
        bins = (luma // 32).astype(int).clip(0, 7)
        weight = 1 / np.maximum(np.bincount(bins, minlength=8), 1)[bins]
        return np.clip(weight / np.median(weight), 0.6, 3)

    def sampling(self, share: dict[str, float], outlined: float | None = None) -> np.ndarray:
        """The probability of drawing each face.  share: of each folder.

        outlined: the weight of mouths outlined by hand; None for the weight that others have.
        """
        p, weight = np.zeros(len(self.pictures)), self.rarity
        if outlined is not None:
            weight = np.where(self.outlined, outlined, weight)
        for name, part in share.items():
            inside = self.folder == name
            p[inside] = part * weight[inside] / weight[inside].sum()
        return p / p.sum()


def look_up(grids: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Bilinear samples (N, K) of depth grids (N, G, G) at points (N, K, 2) in IOD."""
    cells = grids.shape[1]
    place = ((at / DEPTH_REACH + 1) / 2 * (cells - 1)).clip(0, cells - 1.001)
    low = place.astype(int)
    fx, fy = np.moveaxis(place - low, -1, 0)
    x, y, n = low[..., 0], low[..., 1], np.arange(len(grids))[:, None]
    top = grids[n, y, x] * (1 - fx) + grids[n, y, x + 1] * fx
    bottom = grids[n, y + 1, x] * (1 - fx) + grids[n, y + 1, x + 1] * fx
    return top * (1 - fy) + bottom * fy


def rotations(yaw: np.ndarray, pitch: np.ndarray) -> np.ndarray:
    """(N,) angles -> (N, 3, 3); yaw first, then pitch."""
    zero, one = np.zeros_like(yaw), np.ones_like(yaw)
    cy, sy, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    turn = np.stack([cy, zero, sy, zero, one, zero, -sy, zero, cy], -1).reshape(-1, 3, 3)
    nod = np.stack([one, zero, zero, zero, cp, -sp, zero, sp, cp], -1).reshape(-1, 3, 3)
    return nod @ turn


@dataclass
class Batch:
    rgb8: np.ndarray  # (N, H, W, 3)
    points: np.ndarray  # (N, K, 3) in IOD from the crop's centre
    weight: np.ndarray  # (N, K), of each point in the loss
    labels: np.ndarray  # (N, 2): whether there is a face, and a visible mouth
    index: np.ndarray  # (N,) of the face
    # (N, H, W, 4) uint8: the whole mouth, the opening between the lips, the teeth's share of the
    # opening (about 127 where unknown), and whether all this is known; for the lip net only
    mask: np.ndarray | None = None


class _Placed(NamedTuple):
    """How faces are turned, and where their crops lie.

    rotation: (N, 3, 3) in depth. sign: (N,), -1 for a mirrored face. tilt: (N, 2, 2), the face's
    coordinates -> the crop's. centre: (N, 2) of the crop, in IOD of the face as it is turned.
    """

    rotation: np.ndarray
    sign: np.ndarray
    tilt: np.ndarray
    centre: np.ndarray


class Cropper:
    """Draws batches for one net. augment: False leaves only the small errors of a tracker."""

    def __init__(self, faces: Faces, spec: CropSpec, seed: int, augment: bool = True) -> None:
        self.faces, self.spec, self.augment = faces, spec, augment
        self.rng = np.random.default_rng(seed)
        self.p = faces.sampling(spec.share, OUTLINED if spec is SPECS["lips"] else None)
        self.occluder = Occluder(faces.pictures, mouth=spec is SPECS["lips"])
        self.openings = Openings(self.rng)
        w, h = spec.size_wh
        coarse = np.stack(np.meshgrid(np.linspace(0, w - 1, w // 8 + 1),
                                      np.linspace(0, h - 1, h // 8 + 1)), -1)  # fmt: skip
        self.coarse = coarse.reshape(-1, 2).astype(np.float32)  # crop px

    def geometry(self, index: np.ndarray) -> dict[str, np.ndarray]:
        """Where each crop's pixels lie in the picture, px, and the targets of its points, IOD."""
        placed, target = self._draw(index)
        source = self._source(index, placed)
        return {"target": target.astype(np.float32), "source": source.astype(np.float32)}

    def _draw(self, index: np.ndarray) -> tuple[_Placed, np.ndarray]:
        """How faces are turned, where their crops lie, and targets (N, K, 3) of their points."""
        rng, faces, spec, n = self.rng, self.faces, self.spec, len(index)
        wide = rng.random(n) < (0.25 if self.augment else 0)  # the larger error of a first frame
        spread = np.where(wide, 2.5, 1.0)[:, None] * np.array([spec.jitter])
        turn, log_scale = rng.normal(size=(2, n)) * spread.T[:2]
        shift = rng.normal(size=(n, 2)) * spread[:, 2:]
        angle = np.where(rng.random(n) < 0.6, 1.0, 0.0) * self.augment
        yaw, pitch = rng.normal(size=(2, n)) * angle * np.array([spec.turn]).T
        rotation = rotations(yaw, pitch)
        flip = rng.random(n) < 0.5

        points, grids = faces.points[index].copy(), faces.depth[index]
        xy = points[..., :2] - PIVOT
        depth = np.concatenate([xy, look_up(grids, points[..., :2])[..., None]], 2)
        turned = depth @ rotation.transpose(0, 2, 1)
        turned[..., 2] += points[..., 2] - depth[..., 2]
        turned[..., 1] += PIVOT[1]
        sign = np.where(flip, -1.0, 1.0)
        turned[..., 0] *= sign[:, None]
        turned[flip] = turned[flip][:, faces.mirror]

        centre = np.array([spec.centre]).repeat(n, 0)
        if spec.around is not None:
            centre = turned[:, spec.around, :2].mean(1)
        centre = centre + shift
        c, s = np.cos(turn) * np.exp(log_scale), np.sin(turn) * np.exp(log_scale)
        tilt = np.stack([c, -s, s, c], -1).reshape(n, 2, 2)  # face's coordinates -> crop
        target = turned[:, spec.points]
        target = np.concatenate(
            [
                (target[..., :2] - centre[:, None]) @ tilt.transpose(0, 2, 1),
                target[..., 2:] * np.exp(log_scale)[:, None, None],
            ],
            2,
        )
        return _Placed(rotation, sign, tilt, centre), target

    def _source(self, index: np.ndarray, placed: _Placed) -> np.ndarray:
        """Where the coarse grids of the crops lie in the pictures, (N, K, 2) px."""
        faces, spec = self.faces, self.spec
        rotation, sign, tilt, centre = placed
        grids = faces.depth[index]
        size = np.array(spec.size_wh, np.float32)
        offset = (self.coarse - (size - 1) / 2) * (spec.span / size[0])  # IOD
        goal = offset @ np.linalg.inv(tilt).transpose(0, 2, 1) + centre[:, None]
        goal[..., 0] *= sign[:, None]
        goal[..., 1] -= PIVOT[1]
        straight = np.linalg.inv(rotation[:, :2, :2]).transpose(0, 2, 1)
        away = rotation[:, None, :2, 2]  # how depth moves a point
        here = goal @ straight
        # fixed-point iteration for the position before the head was turned
        for _ in range(4 if self.augment else 0):
            z = look_up(grids, here + PIVOT)[..., None]
            here = (goal - z * away) @ straight
        here = here + PIVOT
        poses = faces.poses[index]
        source: np.ndarray = here @ poses[:, :, :2].transpose(0, 2, 1) + poses[:, None, :, 2]
        return source

    def lip_mask(self, face: int, source: np.ndarray, at: np.ndarray) -> np.ndarray:
        """(H, W, 4) as in Batch. Without a good mask, only the places of sure_places are known."""
        w, h = self.spec.size_wh
        if face not in self.faces.masks:
            return sure_places(at, (w, h), w / self.spec.span)
        mask, to_px = self.faces.masks[face]
        rows, columns = mask.shape[:2]
        inverse = np.linalg.inv(to_px[:, :2]) * (columns / MASK_SPAN)
        place = (source - to_px[:, 2]) @ inverse.T + [(columns - 1) / 2, (rows - 1) / 2]
        grid = stretch(place.astype(np.float32).reshape(h // 8 + 1, w // 8 + 1, 2), (w, h))
        drawn = cv2.remap(mask, grid, None, cv2.INTER_LINEAR)
        return np.dstack([drawn, np.full((h, w), 255, np.uint8)])

    def crop(self, face: int, source: np.ndarray) -> np.ndarray:
        """One crop. source: (K, 2), where its coarse grid lies in the picture, px."""
        w, h = self.spec.size_wh
        step = np.hypot(*(source[1] - source[0])) / 8  # source px per crop px
        levels = self.faces.pictures[face]
        level = 0
        while level + 1 < len(levels) and step > (1.6 if self.rng.random() < 0.7 else 2.4):
            level, step = level + 1, step / 2
        scale = np.float32(len(levels[level]) / len(levels[0]))
        coarse = (source * scale + (scale - 1) / 2).reshape(h // 8 + 1, w // 8 + 1, 2)
        grid = stretch(coarse, (w, h))
        border = cv2.BORDER_CONSTANT if self.rng.random() < 0.5 else cv2.BORDER_REPLICATE
        return cv2.remap(levels[level], grid, None, cv2.INTER_LINEAR, borderMode=border)

    def batch(self, n: int, index: np.ndarray | None = None) -> Batch:
        rng, spec = self.rng, self.spec
        if index is None:
            index = rng.choice(len(self.p), n, p=self.p)
        placed = self.geometry(index)
        w, h = spec.size_wh
        rgb8 = np.empty((n, h, w, 3), np.uint8)
        weight = np.ones((n, len(spec.points)), np.float32)
        labels = np.ones((n, 2), np.float32)
        masks = np.zeros((n, h, w, 4), np.uint8) if spec is SPECS["lips"] else None
        covered = self.faces.folder[index] == "covered"
        lower = self.faces.mean[spec.points, 1] > LOWER_FACE
        weight[covered] = np.where(lower, 0.1, 1.0)
        labels[covered, 1] = 0
        for i, face in enumerate(index):
            if self.augment and spec is SPECS["mesh"] and rng.random() < 0.08:
                weight[i], labels[i] = 0, (0, 0)
                rgb8[i] = photograph(self.no_face(face), rng)
                continue
            crop = self.crop(face, placed["source"][i])
            at = placed["target"][i, :, :2] * (w / spec.span) + [(w - 1) / 2, (h - 1) / 2]
            if masks is not None:
                masks[i] = self.lip_mask(face, placed["source"][i], at)
            if self.augment:
                if masks is not None and face in self.faces.masks:
                    crop = restyle(self.openings(crop, masks[i]), masks[i], rng)
                hidden = self.occluder(crop, at, rng)
                if hidden is not None:
                    if masks is not None:
                        cover_mask(masks[i], self.occluder.shape)
                    weight[i] *= np.where(hidden, 0.4, 1.0)
                    mouth = np.isin(spec.points, LIPS)
                    if mouth.any() and hidden[mouth].mean() > 0.6:
                        labels[i, 1] = 0
                if masks is not None and rng.random() < HARSH:
                    crop = harsh(crop, rng)
                crop = photograph(crop, rng)
            rgb8[i] = crop
        return Batch(rgb8, placed["target"], weight, labels, index, masks)

    def no_face(self, face: int) -> np.ndarray:
        """A crop without a face at its centre: background, or a face far off."""
        w, h = self.spec.size_wh
        size = len(self.faces.pictures[face][0])
        unit = np.linalg.norm(self.faces.poses[face][:, 0])  # px per IOD
        while True:
            side = unit * self.spec.span * np.exp(self.rng.normal() * 0.7)
            centre = self.rng.uniform(0, size, 2)
            off = np.linalg.norm(centre - self.faces.poses[face] @ [0, 0.42, 1]) / unit
            if off > 1.0 or abs(np.log(side / unit / self.spec.span)) > 0.9:
                break
        turn = self.rng.normal() * 0.3
        c, s = np.cos(turn) * w / side, np.sin(turn) * w / side
        linear = np.array([[c, -s], [s, c]])
        matrix = np.column_stack([linear, np.array([w, h]) / 2 - linear @ centre])
        return cv2.warpAffine(self.faces.pictures[face][0], matrix, (w, h), flags=cv2.INTER_AREA)

    def stream(self, n: int) -> Iterator[Batch]:
        """New batches and, in between, recent ones mirrored and in another tone: half the work."""
        recent: list[Batch] = []
        while True:
            fresh = self.batch(n)
            yield fresh
            mirrored = mirrored_subset(self.spec.points, self.faces.mirror)
            if mirrored is None:
                continue
            recent.append(fresh)
            if len(recent) > 12:
                yield echo(recent.pop(int(self.rng.integers(6))), mirrored, self.rng)


def mirrored_subset(points: np.ndarray, mirror: np.ndarray) -> np.ndarray | None:
    """Index of each point's mirror image in the same list; None if one is not in the list."""
    order = {int(point): at for at, point in enumerate(points)}
    found = [order.get(int(mirror[point])) for point in points]
    return None if None in found else np.array(found)


def echo(batch: Batch, mirrored: np.ndarray, rng: np.random.Generator) -> Batch:
    tone = np.arange(256)[:, None] * np.exp(rng.normal(0, 0.15) + rng.normal(0, 0.06, 3))
    flipped = np.ascontiguousarray(batch.rgb8[:, :, ::-1])
    n, h, w, _ = flipped.shape
    table = tone.clip(0, 255).astype(np.uint8)[None]
    rgb8 = cv2.LUT(flipped.reshape(n * h, w, 3), table).reshape(flipped.shape)
    points = batch.points[:, mirrored] * np.array([-1, 1, 1], np.float32)
    mask = None if batch.mask is None else np.ascontiguousarray(batch.mask[:, :, ::-1])
    return Batch(rgb8, points, batch.weight[:, mirrored], batch.labels, batch.index, mask)


def stretch(coarse: np.ndarray, size_wh: tuple[int, int]) -> np.ndarray:
    """Bilinear upsampling that keeps the corner samples at the corners."""
    w, h = size_wh
    rows, columns = coarse.shape[:2]
    scale = np.array([[(columns - 1) / (w - 1), 0, 0], [0, (rows - 1) / (h - 1), 0]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(coarse, scale, (w, h), flags=flags, borderMode=cv2.BORDER_REPLICATE)


def sure_places(at: np.ndarray, size_wh: tuple[int, int], unit: float) -> np.ndarray:
    """A mask of where surely no lipstick goes: far outside the lips, and well inside the mouth.

    at: (80, 2) px, the points of LIPS. unit: px per IOD. Returns (H, W, 4) as in Batch.
    """
    outer, inner = 1 - filled(at, LIPS_OUTER, size_wh), filled(at, LIPS_INNER, size_wh)
    outside = cv2.distanceTransform(outer, cv2.DIST_L2, 3) > 0.07 * unit
    within = cv2.distanceTransform(inner, cv2.DIST_L2, 3) > 0.03 * unit
    opening = within * np.uint8(255)
    unknown, known = np.full_like(opening, 127), (outside | within) * np.uint8(255)
    return np.dstack([opening, opening, unknown, known])


def filled(at: np.ndarray, contour: np.ndarray, size_wh: tuple[int, int]) -> np.ndarray:
    """A filled contour of the lips, (H, W) uint8 of 0 and 1. at: (80, 2) px, the points of LIPS."""
    picture = np.zeros(size_wh[::-1], np.uint8)
    fill(picture, at[[LIPS_AT[point] for point in contour]])
    return picture


def cover_mask(mask: np.ndarray, shape: np.ndarray) -> None:
    """Mark the pixels of an occluder, in place, as known to be no part of the mouth."""
    mask[..., :2] = mask[..., :2] * (1 - shape[..., None])
    mask[..., 3] = np.maximum(mask[..., 3], (shape > 0.8) * np.uint8(255))
