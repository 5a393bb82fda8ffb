"""The nets one after the other: where faces are, then the points and the lips of each.

All geometry is upright pixels of a Picture. A *face frame* (2, 3) lays the mean face, whose outer
eye corners are 1 apart (the inter-ocular distance, IOD), over a face; every crop is turned and
scaled by it, so the nets always see an upright face of the same size. docs/models.md tells what
each net was taught.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from makeup_video.pipeline.crop import Affine, Picture
from makeup_video.pipeline.face import LipPatch
from makeup_video.pipeline.net import Net, read_array
from makeup_video.pipeline.topology import EYE, LIPS

FACE_CENTRE = np.array([0.0, 0.42])  # IOD below the middle of the eyes: the middle of a face
_CELL = 8  # px of the detector's picture per cell of its answer
_CELL_GROUP = 32  # its sides must be multiples of this
_MIRRORED = np.array([-1, 1, 1])
_CLOSE = 0.9  # IOD: two faces are no closer than this


@dataclass(frozen=True, slots=True)
class _Window:
    """What a net looks at."""

    size_wh: tuple[int, int]  # px
    span: float  # its width in IOD

    def to_px(self, frame: Affine, centre: np.ndarray, mirrored: bool = False) -> Affine:
        """Crop px -> upright px, turned and scaled as the face frame, its middle at centre."""
        unit = self.span / self.size_wh[0]
        to_px = frame * unit
        if mirrored:
            to_px[:, 0] *= -1
        w, h = self.size_wh
        to_px[:, 2] = centre - to_px[:, :2] @ [(w - 1) / 2, (h - 1) / 2]
        return to_px


_MESH = _Window((96, 96), 2.56)
_LIPS = _Window((112, 80), 1.15)
_EYE = _Window((64, 48), 0.72)


class FaceNets:
    """All four nets and the mean face, loaded once."""

    def __init__(self) -> None:
        self.detector, self.mesh = Net("detector"), Net("mesh")
        self.lips, self.eye = Net("lips"), Net("eye")
        self.mean_face = read_array("mean_face.npy").astype(np.float64)  # (478, 3) IOD
        self.mirror = read_array("mirror.npy").astype(int)  # (478,) the point on the other side
        self._eyes = (EYE, self.mirror[EYE])
        middle = self.mean_face[:, :2].mean(0)
        self._middle = float(middle[0]), float(middle[1])
        centred = self.mean_face[:, :2] - middle
        self._fit = (centred / (centred**2).sum()).T  # (2, 478)
        order = {int(point): at for at, point in enumerate(LIPS)}
        self._lips_mirror = np.array([order[int(self.mirror[point])] for point in LIPS])

    def face_frame(self, points: np.ndarray) -> Affine:
        """(478, >=2) -> (2, 3), the frame of a face with these points: a least-squares fit.

        The same as fit_similarity(mean_face, points), whose result is linear in the points.
        """
        xy = points[:, :2].astype(np.float64)
        (xx, xy_), (yx, yy) = (self._fit @ xy).tolist()
        a, b = xx + yy, xy_ - yx
        x, y = xy.mean(0).tolist()
        mid_x, mid_y = self._middle
        return np.array([
            [a, -b, x - a * mid_x + b * mid_y],
            [b, a, y - b * mid_x - a * mid_y],
        ])  # fmt: skip

    def detect(self, picture: Picture, side_px: int, threshold: float) -> list[Affine]:
        """Face frames, surest first; the picture is looked at with its longer side at side_px."""
        scale = max(picture.width_px, picture.height_px, 1) / side_px
        size = np.array([picture.width_px, picture.height_px]) / scale
        w, h = (max(1, round(float(side))) for side in size)
        to_px = np.array([[scale, 0, 0.5 * scale - 0.5], [0, scale, 0.5 * scale - 0.5]])
        padded_w, padded_h = (-(-side // _CELL_GROUP) * _CELL_GROUP for side in (w, h))
        seen = np.zeros((1, padded_h, padded_w, 3), np.uint8)
        seen[0, :h, :w] = picture.crop(to_px, (w, h))
        return _decode_cells(self.detector(seen)["cells"][0], scale, threshold)

    def read_mesh(
        self, picture: Picture, frame: Affine, mirrored: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """-> points (478, 3) px, and (2,) probabilities: a face is there, its mouth is visible."""
        centre = middle_of(frame)
        out = self.mesh(picture.crop(_MESH.to_px(frame, centre, mirrored), _MESH.size_wh)[None])
        points = out["points"][0]
        if mirrored:
            points = points[self.mirror] * _MIRRORED
        return _place(points, frame, centre), out["scores"][0]

    def read_lips(
        self, picture: Picture, points: np.ndarray, frame: Affine, both_ways: bool = False
    ) -> tuple[np.ndarray, LipPatch]:
        """-> points (80, 2) px of LIPS, and where lipstick goes; its to_px is upright px.

        both_ways: look at the mirrored crop too, and take the mean: truer, for twice the work.
        """
        centre = points[LIPS, :2].mean(0)
        to_px = _LIPS.to_px(frame, centre)
        crop = picture.crop(to_px, _LIPS.size_wh)
        out = self.lips(np.stack([crop, crop[:, ::-1]] if both_ways else [crop]))
        offsets, logits = out["points"], out["mask_logits"]
        if both_ways:
            offsets = (offsets[:1] + offsets[1:, self._lips_mirror] * _MIRRORED) / 2
            logits = (logits[:1] + logits[1:, :, ::-1]) / 2
        return _place(offsets[0], frame, centre)[:, :2], LipPatch(logits[0], to_px)

    def read_eyes(self, picture: Picture, points: np.ndarray, frame: Affine) -> list[np.ndarray]:
        """-> the points (53, 2) px of EYE, and of the other eye."""
        centres = [points[index[:16], :2].mean(0) for index in self._eyes]
        crops = [
            picture.crop(_EYE.to_px(frame, centre, mirrored=bool(side)), _EYE.size_wh)
            for side, centre in enumerate(centres)
        ]
        found = self.eye(np.stack(crops))["points"] * np.array([[[1, 1, 1]], [_MIRRORED]])
        return [
            _place(eye, frame, centre)[:, :2] for eye, centre in zip(found, centres, strict=True)
        ]

    def refine(self, picture: Picture, points: np.ndarray, both_ways: bool = False) -> LipPatch:
        """Look at lips and eyes more closely, and move `points` (478, 3) px there, in place."""
        frame = self.face_frame(points)
        points[LIPS, :2], patch = self.read_lips(picture, points, frame, both_ways)
        for index, xy in zip(self._eyes, self.read_eyes(picture, points, frame), strict=True):
            points[index, :2] = xy
        return patch


def _place(offsets: np.ndarray, frame: Affine, centre: np.ndarray) -> np.ndarray:
    """A net's points (K, 3) in IOD from a crop's middle -> (K, 3) px."""
    placed = np.empty((len(offsets), 3))
    placed[:, :2] = offsets[:, :2] @ frame[:, :2].T + centre
    placed[:, 2] = offsets[:, 2] * iod_of(frame)
    return placed


def _decode_cells(cells: np.ndarray, scale: float, threshold: float) -> list[Affine]:
    """(6, rows, columns) of the detector -> face frames in px, surest first.

    scale: px per px of the detector's picture. Per cell: the logit of a face, dx and dy to its
    middle in cells, the logarithm of its IOD in cells, cosine and sine of its turn.
    """
    logit = cells[0]
    peak = cv2.dilate(logit, np.ones((3, 3))) <= logit
    rows, columns = np.nonzero(peak & (logit > np.log(threshold / (1 - threshold))))
    frames: list[Affine] = []
    for at in np.argsort(-logit[rows, columns]):
        row, column = rows[at], columns[at]
        dx, dy, size, cosine, sine = cells[1:, row, column].astype(np.float64)
        centre = ((np.array([column + dx, row + dy]) + 0.5) * _CELL - 0.5) * scale
        iod = np.exp(min(size, 8.0)) * _CELL * scale
        cosine, sine = np.array([cosine, sine]) / max(np.hypot(cosine, sine), 1e-6)
        linear = iod * np.array([[cosine, -sine], [sine, cosine]])
        if all(np.hypot(*(middle_of(f) - centre)) > _CLOSE * iod for f in frames):
            frames.append(np.column_stack([linear, centre - linear @ FACE_CENTRE]))
    return frames


def middle_of(frame: Affine) -> np.ndarray:
    """(2,) px: the middle of a face."""
    middle: np.ndarray = frame @ [*FACE_CENTRE, 1]
    return middle


def iod_of(frame: Affine) -> float:
    """The inter-ocular distance in px."""
    return float(np.hypot(*frame[:, 0]))
