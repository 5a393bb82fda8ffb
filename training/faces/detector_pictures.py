"""Draws training pictures for the detector: faces of any size, and scenes without a face."""

import cv2
import numpy as np
import skimage.data
from makeup_video.training.faces.augment import Occluder, photograph
from makeup_video.training.faces.crops import Faces
from makeup_video.training.faces.occluders import blot_out, cover, decoy

SCENE = 256  # px
STRIDE = 8  # px per cell of the detector's output
FACE_CENTRE = np.array([0.0, 0.42])  # IOD from the midpoint of the eyes; y is down
IOD_RANGE = (4.5, 150.0)  # px in the scene; a face is about twice as wide
CROWD_IOD = (4.5, 12.0)  # px
NOSE_TIP = 1  # of the 478 points
KINDS = {  # kinds of scenes, and how often each is drawn
    "whole": 0.34,  # one whole picture
    "close": 0.18,  # one face that fills the scene, or is cut off by its border
    "mixed": 0.24,  # faces of any size pasted anywhere
    "crowd": 0.04,  # many small faces: each weighs as much in the loss as a large one
    "empty": 0.2,
}
BACKDROPS = ("coffee", "rocket", "chelsea", "brick", "grass", "gravel", "page", "text", "clock",
             "coins", "moon", "hubble_deep_field", "immunohistochemistry", "colorwheel",
             "cell", "horse")  # fmt: skip


def backdrops() -> list[np.ndarray]:
    """Pictures without a face from scikit-image's wheel, which need no download."""
    pictures = []
    for name in BACKDROPS:
        try:
            picture = getattr(skimage.data, name)()
        except (AttributeError, OSError, ModuleNotFoundError) as error:
            # not in the wheel: the others are enough
            print("no backdrop", name, type(error).__name__)
            continue
        if picture.dtype == bool:
            picture = picture.astype(np.uint8) * 255
        rgb8 = picture if picture.ndim == 3 else np.dstack([picture] * 3)
        pictures.append(np.ascontiguousarray(rgb8[..., :3]))
    return pictures


class Scenes:
    """Draws (scene (256, 256, 3) uint8, faces (F, 4): centre x, y, IOD px, turn in radians).

    Scenes that are not square lie top left, and the rest is black, as in a letterbox.
    """

    def __init__(self, faces: Faces, seed: int) -> None:
        self.faces, self.rng = faces, np.random.default_rng(seed)
        share = {"portraits": 0.2, "wild": 0.5, "talking": 0.15, "covered": 0.15}
        turned = np.abs(faces.points[:, NOSE_TIP, 0]).clip(0, 0.3)  # IOD; 0 seen from the front
        p = faces.sampling(share) * (1 + 6 * turned)
        self.cumulative = np.cumsum(p / p.sum())
        self.backdrops = backdrops()
        self.occluder = Occluder(faces.pictures)

    def draw(self, kind: str | None = None) -> tuple[np.ndarray, np.ndarray]:
        rng = self.rng
        if kind is None:
            kind = str(rng.choice(list(KINDS), p=list(KINDS.values())))
        w, h = self._size()
        scene, found = self._ground(w, h), []
        if kind in ("whole", "close"):
            found.append(self._fill(scene, close=kind == "close"))
        self._decoys(scene, kind)
        counts = {"whole": rng.choice([0, 1, 2], p=[0.7, 0.2, 0.1]), "mixed": rng.integers(1, 6),
                  "crowd": rng.integers(8, 25)}  # fmt: skip
        for _ in range(int(counts.get(kind, 0))):
            placed = self._scatter(scene, found, CROWD_IOD if kind == "crowd" else IOD_RANGE)
            if placed is not None:
                found.append(placed)
        for face in found:
            if face[2] > 8 and rng.random() < 0.3:
                cover(scene, face, rng)
        if rng.random() < 0.3:
            self.occluder(scene, np.zeros((1, 2)), rng)
        faces = np.array(found, np.float32).reshape(-1, 4)
        if rng.random() < 0.5:
            scene = np.ascontiguousarray(scene[:, ::-1])
            faces = faces * [-1, 1, 1, -1] + [w - 1, 0, 0, 0]
        if rng.random() < 0.2:
            scene = ill_exposed(scene, rng)
        boxed = np.zeros((SCENE, SCENE, 3), np.uint8)
        boxed[:h, :w] = photograph(scene, rng)
        return boxed, faces

    def _face(self) -> int:
        at = int(np.searchsorted(self.cumulative, self.rng.random()))
        return min(at, len(self.cumulative) - 1)

    def _size(self) -> tuple[int, int]:
        w = h = SCENE
        if self.rng.random() < 0.3:
            short = int(self.rng.uniform(0.5, 1) * SCENE)
            w, h = (w, short) if self.rng.random() < 0.6 else (short, h)
        return w, h

    def _ground(self, w: int, h: int) -> np.ndarray:
        rng = self.rng
        if rng.random() < 0.3:
            cells = int(rng.integers(1, 24))
            noise = rng.integers(0, 255, (cells, cells, 3)).astype(np.uint8)
            return cv2.resize(noise, (w, h), interpolation=cv2.INTER_CUBIC)
        if rng.random() < 0.5:
            picture = self.backdrops[int(rng.integers(len(self.backdrops)))]
            side = int(min(picture.shape[:2]) * rng.uniform(0.2, 1))
        else:
            picture = self._surroundings()
            side = min(picture.shape[:2])
            if side < 12:
                return np.full((h, w, 3), rng.integers(0, 255, 3), np.uint8)
        y, x = (int(rng.integers(0, size - side + 1)) for size in picture.shape[:2])
        part = picture[y : y + side, x : x + side]
        return cv2.resize(part, (w, h), interpolation=cv2.INTER_AREA)

    def _surroundings(self) -> np.ndarray:
        """The surroundings of some face: clothes, walls, hair. May be empty."""
        face = self._face()
        picture = self.faces.pictures[face][0]
        x, y = self.faces.poses[face] @ [*FACE_CENTRE, 1]
        unit = np.linalg.norm(self.faces.poses[face][:, 0])
        right, below = int(x + 1.1 * unit), int(y + 1.5 * unit)
        left = max(int(x - 1.1 * unit), 0)
        strips = [picture[below:], picture[:, right:], picture[:, :left]]
        return max(strips, key=lambda strip: min(strip.shape[:2]))

    def _fill(self, scene: np.ndarray, close: bool) -> np.ndarray:
        """Lay one whole picture over the scene, about as large as the scene.

        close: the face is large, and the border may cut it off.
        """
        rng, face = self.rng, self._face()
        h, w = scene.shape[:2]
        if close:
            wanted = np.exp(rng.uniform(np.log(50), np.log(IOD_RANGE[1])))
            cut = rng.random() < 0.5  # anywhere: the border cuts off half of the face at most
            centre = rng.uniform(0.02, 0.98, 2) if cut else 0.5 + rng.normal(size=2) * 0.1
        else:
            unit = np.linalg.norm(self.faces.poses[face][:, 0])
            side = len(self.faces.pictures[face][0])
            wanted = unit * min(w, h) / side * np.exp(rng.normal() * 0.3)
            wanted = min(wanted, IOD_RANGE[1])
            centre = 0.5 + rng.normal(size=2) * 0.1
        centre = centre.clip(0.02, 0.98) * [w, h]
        return self._paste(scene, face, wanted, centre, whole=True)

    def _scatter(
        self, scene: np.ndarray, among: list[np.ndarray], iod: tuple[float, float]
    ) -> np.ndarray | None:
        """Paste a face anywhere; None if other faces are in the way."""
        rng = self.rng
        h, w = scene.shape[:2]
        high = iod[1] * 0.6 if iod == IOD_RANGE else iod[1]
        wanted = np.exp(rng.uniform(np.log(iod[0]), np.log(high)))
        centre = rng.uniform(0.04, 0.96, 2) * [w, h]
        for other in among:
            if np.hypot(*(centre - other[:2])) < 1.6 * (wanted + other[2]):
                return None
        return self._paste(scene, self._face(), wanted, centre, whole=False)

    def _decoys(self, scene: np.ndarray, kind: str) -> None:
        """Add heads without faces, and hands and skin anywhere."""
        rng = self.rng
        if kind == "empty" and rng.random() < 0.5:
            for _ in range(int(rng.integers(1, 4))):
                whole = rng.random() < 0.5
                face = self._fill(scene, False) if whole else self._scatter(scene, [], (15, 90))
                blot_out(scene, face, rng)
        if kind in ("empty", "mixed", "crowd") and rng.random() < 0.4:
            face = self._face()
            picture = self.faces.pictures[face][0]
            x, y = (self.faces.poses[face] @ [0.4, 0.42, 1]).astype(int)  # a cheek
            side = len(picture) - 1
            skin = picture[np.clip(y, 0, side), np.clip(x, 0, side)].astype(float)
            for _ in range(int(rng.integers(1, 5))):
                decoy(scene, skin, rng)

    def _paste(
        self, scene: np.ndarray, face: int, wanted: float, centre: np.ndarray, whole: bool
    ) -> np.ndarray:
        """Lay a picture, or a part of it around the face, over the scene."""
        rng = self.rng
        picture, pose = self._reduced(face, wanted)
        unit = np.linalg.norm(pose[:, 0])
        turn = rng.normal() * (0.15 if rng.random() < 0.65 else 0.5)
        c, s = np.cos(turn) * wanted / unit, np.sin(turn) * wanted / unit
        linear = np.array([[c, -s], [s, c]])
        middle = pose @ [*FACE_CENTRE, 1]
        offset = centre - linear @ middle
        weight, box = self._cut(picture.shape[:2], middle, unit, whole)
        corners = box[[[0, 1], [2, 1], [2, 3], [0, 3]]] @ linear.T + offset
        h, w = scene.shape[:2]
        low = np.floor(corners.min(0)).clip(0, [w - 1, h - 1]).astype(int)
        high = np.ceil(corners.max(0)).clip(low + 1, [w, h]).astype(int)
        matrix, size = np.column_stack([linear, offset - low]), tuple((high - low).tolist())
        layer = cv2.warpAffine(picture, matrix, size)
        alpha = cv2.warpAffine(weight, matrix, size)[..., None]
        target = scene[low[1] : high[1], low[0] : high[0]]
        target[:] = target + alpha * (layer - target.astype(np.float32))
        angle = np.arctan2(*(linear @ pose[:, 0])[::-1])
        return np.array([*centre, wanted, angle])

    def _reduced(self, face: int, wanted: float) -> tuple[np.ndarray, np.ndarray]:
        """The picture, halved as long as its IOD stays over `wanted` px, and the pose in it."""
        levels, pose = self.faces.pictures[face], self.faces.poses[face].astype(float)
        unit, level = np.linalg.norm(pose[:, 0]), 0
        while level + 1 < len(levels) and unit / 2 ** (level + 1) > wanted:
            level += 1
        picture = levels[level]
        while wanted < unit / 2 ** (level + 1):
            picture = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
            level += 1
        pose = pose / 2**level
        pose[:, 2] += (0.5**level - 1) / 2  # a pixel's position is that of its centre
        return picture, pose

    def _cut(
        self, shape: tuple[int, int], middle: np.ndarray, unit: float, whole: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """The part of the picture to paste (all, a box, an oval around the head), and its box."""
        weight = np.zeros(shape, np.float32)
        box = np.array([0, 0, shape[1], shape[0]], float)  # x, y, right, bottom
        kind = self.rng.random()
        if whole or kind < 0.35:
            weight[:] = 1
            return weight, box
        if kind < 0.75:
            margin = self.rng.uniform(1.3, 2.6, 4) * unit
            box = np.concatenate([middle - margin[:2], middle + margin[2:]])
            x, y, right, bottom = box.astype(int).tolist()
            cv2.rectangle(weight, (x, y), (right, bottom), 1, -1)
        else:
            axes = (int(1.15 * unit), int(1.5 * unit))
            box = np.concatenate([middle - axes, middle + axes])
            cv2.ellipse(weight, tuple(np.rint(middle).astype(int).tolist()), axes, 0, 0, 360, 1, -1)
        return weight, box


def ill_exposed(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The picture at night, overexposed, in fog, under a coloured lamp, or grey.

    (H, W, 3) uint8.
    """
    picture, kind = rgb8.astype(np.float32), rng.random()
    if kind < 0.3:
        picture *= rng.uniform(0.1, 0.4)
    elif kind < 0.5:
        picture *= rng.uniform(1.8, 3.2)
    elif kind < 0.7:
        picture = picture * rng.uniform(0.1, 0.4) + rng.uniform(10, 150)
    elif kind < 0.85:
        picture *= rng.uniform(0.15, 1.2, 3).astype(np.float32)
    else:
        picture = picture.mean(2, keepdims=True) * np.ones(3, np.float32)
    return picture.clip(0, 255).astype(np.uint8)
