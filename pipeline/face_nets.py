"""The nets one after the other: where faces are, then the points and the lips of each.

All geometry is upright pixels of a Picture. A *face frame* (2, 3) lays the mean face, whose outer
eye corners are 1 apart (the inter-ocular distance, IOD), over a face; every crop is turned and
scaled by it, so the nets always see an upright face of the same size. docs/models.md tells what
each net was taught.
"""

import cmath
import math
from dataclasses import dataclass
from importlib.resources.abc import Traversable

import cv2
import numpy as np
from makeup_video.pipeline.crop import Affine, Picture, compose
from makeup_video.pipeline.face import PATCH_SPAN, POINTS, LipPatch
from makeup_video.pipeline.net import SHIPPED, Net, read_array
from makeup_video.pipeline.topology import EYE, EYE_CONTOUR, LIPS

_BELOW_EYES = 0.42  # IOD: the middle of a face is so far below the middle of the eyes
_RIMS = slice(16, 48)  # of EYE: two rings around the lids
_LEAST_SHARE = 0.2  # of a new reading of what is not painted
_CELL = 8  # px of the detector's picture per cell of its answer
_CELL_GROUP = 32  # its sides must be multiples of this
_MIRRORED = np.array([-1, 1, 1])
_LARGE_CELLS = 3.0  # IOD: the cells around its middle then all belong to a face
_CLOSE = 0.9  # IOD: two faces are no closer than this


@dataclass(frozen=True, slots=True)
class _Window:
    """What a net looks at."""

    size_wh: tuple[int, int]  # px
    span: float  # its width in IOD

    def to_px(self, frame: Affine, centre: np.ndarray, mirrored: bool = False) -> Affine:
        """Crop px -> upright px, turned and scaled as the face frame, its middle at centre."""
        unit = self.span / self.size_wh[0]
        (a, b, _), (c, d, _) = (frame * unit).tolist()
        if mirrored:
            a, c = -a, -c
        x, y = (self.size_wh[0] - 1) / 2, (self.size_wh[1] - 1) / 2
        return np.array([
            [a, b, centre[0] - a * x - b * y],
            [c, d, centre[1] - c * x - d * y],
        ])  # fmt: skip


_MESH = _Window((96, 96), 2.56)
_LIPS = _Window((112, 80), PATCH_SPAN)
_EYE = _Window((64, 48), 0.72)


@dataclass(frozen=True, slots=True)
class View:
    """Where the nets look at a face, in upright px.

    frame: the face frame of all crops. centres: (3, 2), middles of the crops of lips and eyes.
    """

    frame: Affine
    centres: np.ndarray

    def strayed(self, other: "View") -> float:
        """How far another view is off: IOD, log scale or radians, whichever is most."""
        off = np.abs(self.centres - other.centres).max() / iod_of(self.frame)
        return max(float(off), distance(self.frame, other.frame))


class FaceNets:
    """All four nets and the mean face, loaded once."""

    def __init__(self, folder: Traversable = SHIPPED) -> None:
        self.detector, self.mesh = Net("detector", folder), Net("mesh", folder)
        self.lips, self.eye = Net("lips", folder), Net("eye", folder)
        self.mean_face = read_array("mean_face.npy", folder).astype(np.float64)  # (478, 3) IOD
        self.mirror = read_array("mirror.npy", folder).astype(int)  # (478,) the other side's point
        self._eyes = (EYE, self.mirror[EYE])
        self._eye_contours = (EYE_CONTOUR, self.mirror[EYE_CONTOUR])
        # rows: means of the lips, of both lid contours, and of the rims, which lids do not move
        of = (LIPS, *self._eye_contours, *(eye[_RIMS] for eye in self._eyes))
        self._means = np.zeros((len(of), POINTS))
        for row, index in zip(self._means, of, strict=True):
            row[index] = 1 / len(index)
        self.far_points = np.setdiff1d(np.arange(POINTS), [*LIPS, *self._eyes[0], *self._eyes[1]])
        middle = self.mean_face[:, :2].mean(0)
        self._middle = float(middle[0]), float(middle[1])
        centred = self.mean_face[:, :2] - middle
        self._fit = np.ascontiguousarray((centred / (centred**2).sum()).T)  # (2, 478)
        order = {int(point): at for at, point in enumerate(LIPS)}
        self._lips_mirror = np.array([order[int(self.mirror[point])] for point in LIPS])

    def face_frame(self, points: np.ndarray) -> Affine:
        """(478, >=2) -> (2, 3), the frame of a face with these points: a least-squares fit.

        The same as fit_similarity(mean_face, points), whose result is linear in the points.
        """
        fit_x, fit_y = self._fit
        px, py = points[:, 0], points[:, 1]
        a = float(fit_x.dot(px) + fit_y.dot(py))
        b = float(fit_x.dot(py) - fit_y.dot(px))
        x, y = float(px.mean()), float(py.mean())
        mid_x, mid_y = self._middle
        return np.array([
            [a, -b, x - a * mid_x + b * mid_y],
            [b, a, y - b * mid_x - a * mid_y],
        ])  # fmt: skip

    def detect(
        self, picture: Picture, side_px: int, threshold: float, tilt_degrees: float = 0
    ) -> list[tuple[float, Affine]]:
        """(logit, face frame), surest first; the picture is seen with its longer side at side_px.

        tilt_degrees: how far the picture is turned for that; the detector knows heads that tilt
        up to 30 degrees or so.
        """
        size = np.array([picture.width_px, picture.height_px])
        scale = max(*size, 1) / side_px
        turn = np.radians(tilt_degrees)
        c, s = np.cos(turn), np.sin(turn)
        w, h = np.maximum(np.rint(np.abs([[c, s], [s, c]]) @ size / scale), 1).astype(int).tolist()
        linear = scale * np.array([[c, -s], [s, c]])
        middle = (size - 1) / 2 - linear @ [(w - 1) / 2, (h - 1) / 2]
        to_px = np.column_stack([linear, middle])
        padded_w, padded_h = (-(-side // _CELL_GROUP) * _CELL_GROUP for side in (w, h))
        seen = np.zeros((1, padded_h, padded_w, 3), np.uint8)
        seen[0, :h, :w] = picture.crop(to_px, (w, h))
        found = decode_cells(self.detector(seen)["cells"][0], threshold)
        return [(logit, compose(to_px, frame)) for logit, frame in found]

    def read_mesh(
        self, picture: Picture, frame: Affine, mirrored: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """-> points (478, 3) px, and (2,) probabilities: a face is there, its mouth is visible."""
        centre = middle_of(frame)
        out = self.mesh(picture.crop(_MESH.to_px(frame, centre, mirrored), _MESH.size_wh)[None])
        offsets = out["points"][0]
        if mirrored:
            offsets = offsets[self.mirror] * _MIRRORED
        points = np.empty((len(offsets), 3))
        points[:, :2] = _place_xy(offsets, frame, centre)
        points[:, 2] = offsets[:, 2] * iod_of(frame)
        return points, out["scores"][0]

    def middles(self, points: np.ndarray) -> np.ndarray:
        """(5, 2): the middles of lips, lids of either eye, and rim of either eye (478, >=2)."""
        middles: np.ndarray = self._means @ points[:, :2]
        return middles

    def view(self, points: np.ndarray, frame: Affine | None = None) -> View:
        """Where to look at a face with these points (478, >=2) px; frame: if known already."""
        return View(self.face_frame(points) if frame is None else frame, self.middles(points)[:3])

    def refine(
        self, picture: Picture, points: np.ndarray, view: View, both_ways: bool = False
    ) -> LipPatch:
        """Look at lips and eyes more closely, and move `points` (478, 3) px there, in place.

        both_ways: look at the mirrored lips too, and take the mean: truer, for more work. Returns
        where lipstick goes; its to_px is upright px.
        """
        frame, centres = view.frame, view.centres
        to_px = _LIPS.to_px(frame, centres[0])
        windows = [(to_px, _LIPS.size_wh)]
        for side in (0, 1):
            at = _EYE.to_px(frame, centres[1 + side], mirrored=bool(side))
            windows.append((at, _EYE.size_wh))
        lips, *eyes = picture.crops(windows)
        offsets, logits = self._read_lips(lips, both_ways)
        points[LIPS, :2] = _place_xy(offsets, frame, centres[0])
        found = self.eye(np.stack(eyes))["points"]
        found[1, :, 0] *= -1  # it was seen mirrored
        for index, eye, centre in zip(self._eyes, found, centres[1:], strict=True):
            points[index, :2] = _place_xy(eye, frame, centre)
        return LipPatch(logits, to_px)

    def take_rest(self, points: np.ndarray, mesh: np.ndarray, strayed_px: float) -> bool:
        """Take from the mesh net's points all but lips and eyes; these too where they strayed.

        Where the rest hardly differs, only a part of the difference is taken: it is noise, and
        would jolt the face's pose. True when lips or eyes had strayed.
        """
        off = (mesh - points)[self.far_points]
        share = 14 * float(np.abs(off[:, :2]).mean()) / max(strayed_px, 1e-9)
        points[self.far_points] += min(max(share, _LEAST_SHARE), 1) * off
        strayed = False
        for index in (LIPS, *self._eyes):
            points[index, 2] = mesh[index, 2]
            x, y = (points[index, :2] - mesh[index, :2]).mean(0).tolist()
            if math.hypot(x, y) > strayed_px:
                points[index], strayed = mesh[index], True
        return strayed

    def _read_lips(self, crop: np.ndarray, both_ways: bool) -> tuple[np.ndarray, np.ndarray]:
        """(80, 112, 3) uint8 -> points (80, 3) in IOD, logits (80, 112)."""
        if not both_ways:
            out = self.lips(crop[None])
            return out["points"][0], out["mask_logits"][0]
        out = self.lips(np.stack([crop, crop[:, ::-1]]))
        (offsets, mirrored), logits = out["points"], out["mask_logits"]
        offsets = (offsets + mirrored[self._lips_mirror] * _MIRRORED) / 2
        return offsets, (logits[0] + logits[1, :, ::-1]) / 2


def _place_xy(offsets: np.ndarray, frame: Affine, centre: np.ndarray) -> np.ndarray:
    """A net's points (K, 3) in IOD from a crop's middle -> (K, 2) px."""
    (a, b, _), (c, d, _) = frame.tolist()
    x, y = offsets[:, 0], offsets[:, 1]
    placed = np.empty((len(offsets), 2))
    placed[:, 0] = a * x + b * y + centre[0]
    placed[:, 1] = c * x + d * y + centre[1]
    return placed


def decode_cells(cells: np.ndarray, threshold: float) -> list[tuple[float, Affine]]:
    """(6, rows, columns) of the detector -> (logit, face frame) in px of its picture, surest first.

    Per cell: the logit of a face, dx and dy to its middle in cells, the logarithm of its IOD in
    cells, cosine and sine of its turn.
    """
    logit = cells[0]
    peak = cv2.dilate(logit, np.ones((3, 3))) <= logit
    rows, columns = np.nonzero(peak & (logit > np.log(threshold / (1 - threshold))))
    found: list[tuple[float, Affine]] = []
    for at in np.argsort(-logit[rows, columns]):
        row, column = rows[at], columns[at]
        dx, dy, size, cosine, sine = _told_around(cells, row, column).tolist()
        centre = (np.array([column + dx, row + dy]) + 0.5) * _CELL - 0.5
        iod = np.exp(min(size, 8.0)) * _CELL
        length = max(math.hypot(cosine, sine), 1e-6)
        cosine, sine = cosine / length, sine / length
        linear = iod * np.array([[cosine, -sine], [sine, cosine]])
        if all(np.hypot(*(middle_of(f) - centre)) > _CLOSE * iod for _, f in found):
            frame = np.column_stack([linear, centre - linear @ [0, _BELOW_EYES]])
            found.append((float(logit[row, column]), frame))
    return found


def _told_around(cells: np.ndarray, row: int, column: int) -> np.ndarray:
    """(5,) what the cell of a large face tells, averaged with its neighbours, surer ones more.

    A small face's neighbours may belong to another, so its own cell speaks alone.
    """
    own = cells[1:, row, column]
    if own[2] < math.log(_LARGE_CELLS):
        return own
    rows, columns = slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2)
    told = cells[1:, rows, columns].copy()
    y, x = np.mgrid[: cells.shape[1], : cells.shape[2]]
    told[0] += x[rows, columns] - column
    told[1] += y[rows, columns] - row
    sure = 1 / (1 + np.exp(-cells[0, rows, columns]))
    mean: np.ndarray = (told * sure).sum((1, 2)) / sure.sum()
    return mean


def distance(a: Affine, b: Affine) -> float:
    """The largest of shift (IOD), log scale and turn (radians) between two face frames."""
    ratio = complex(*b[:, 0]) / complex(*a[:, 0])
    shift = abs(complex(*(middle_of(a) - middle_of(b)))) / iod_of(a)
    return max(shift, abs(math.log(max(abs(ratio), 1e-6))), abs(cmath.phase(ratio)))


def middle_of(frame: Affine) -> np.ndarray:
    """(2,) px: the middle of a face."""
    (_, b, x), (_, d, y) = frame.tolist()
    return np.array([x + _BELOW_EYES * b, y + _BELOW_EYES * d])


def iod_of(frame: Affine) -> float:
    """The inter-ocular distance in px."""
    (a, _, _), (c, _, _) = frame.tolist()
    return math.hypot(a, c)
