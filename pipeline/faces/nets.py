"""The nets one after the other: where faces are, then the points and the lips of each.

All geometry is upright pixels of a Picture, places in it are complex numbers, x + iy. A *face frame*
is the similarity that lays the mean face, whose outer eye corners are 1 apart (the inter-ocular
distance, IOD), over a face; every crop is turned and scaled by it, so the nets always see an
upright face of the same size. docs/models.md tells what each net was taught.
"""

import math
from dataclasses import dataclass
from functools import cache
from importlib.resources.abc import Traversable
from typing import NamedTuple

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import PATCH_SPAN, POINTS, LipPatch
from makeup_video.pipeline.faces.net import SHIPPED, Net, read_array
from makeup_video.pipeline.faces.similarity import (
    BELOW_EYES,
    Similarity,
    distance,
    from_matrix,
    iod_of,
    middle_of,
)
from makeup_video.pipeline.faces.topology import EYE, EYE_CONTOUR, LIPS
from makeup_video.pipeline.frames.affine import AffineArray
from makeup_video.pipeline.frames.views import Picture

_RIMS = slice(16, 48)  # of EYE: two rings around the lids
_LEAST_SHARE = 0.2  # of a new reading of what is not painted
_CELL = 8  # px of the detector's picture per cell of its answer
_CELL_GROUP = 32  # its sides must be multiples of this
_MIRRORED = np.array([-1, 1, 1])
_LARGE_CELLS = 3.0  # IOD: the cells around its middle then all belong to a face
_AROUND = np.ones((3, 3), np.uint8)
_CLOSE = 0.9  # IOD: two faces are no closer than this


@dataclass(frozen=True, slots=True)
class _NetInput:
    """What a net looks at."""

    size_wh: tuple[int, int]  # px
    span: float  # its width in IOD

    def to_px(
        self, frame: Similarity, centre: complex, mirrored: bool = False
    ) -> list[list[float]]:
        """(2, 3), crop px -> upright px, turned and scaled as the face frame, its middle at centre."""
        turn = frame.turn * (self.span / self.size_wh[0])
        across = -turn if mirrored else turn
        x, y = (self.size_wh[0] - 1) / 2, (self.size_wh[1] - 1) / 2
        corner = centre - across * x - turn * complex(0, y)
        return [
            [across.real, -turn.imag, corner.real],
            [across.imag, turn.real, corner.imag],
        ]


_MESH = _NetInput((96, 96), 2.56)
_LIPS = _NetInput((112, 80), PATCH_SPAN)
_EYE = _NetInput((64, 48), 0.72)


class View(NamedTuple):
    """Where the nets look at a face, in upright px.

    frame: the face frame of all crops. centres: middles of the crops of lips and either eye.
    """

    frame: Similarity
    centres: tuple[complex, complex, complex]

    def strayed(self, other: "View") -> float:
        """How far another view is off: IOD, log scale or radians, whichever is most."""
        off = [a - b for a, b in zip(self.centres, other.centres, strict=True)]
        furthest = max(max(abs(each.real), abs(each.imag)) for each in off)
        return max(furthest / iod_of(self.frame), distance(self.frame, other.frame))


def lips_to_px(view: View) -> AffineArray:
    """Where the lip patch of a view lies: (2, 3), its px to upright px."""
    return np.array(_LIPS.to_px(view.frame, view.centres[0]))


class Mesh(NamedTuple):
    """What the mesh net tells: xy (478,) complex128 px, z (478,) px; and two probabilities: a face is
    there, its mouth is visible."""

    xy: np.ndarray
    z: np.ndarray
    scores: tuple[float, float]


class Close(NamedTuple):
    """What the nets of lips and eyes tell: xy (186,) complex128 px of `FaceNets.close_points`; where
    lipstick goes, its to_px to upright px; see `FaceNets.middles`."""

    xy: np.ndarray
    lips: LipPatch
    middles: list[complex]


class FaceNets:
    """All four nets and the mean face, loaded once."""

    def __init__(self, folder: Traversable = SHIPPED) -> None:
        self.detector, self.mesh = Net("detector", folder), Net("mesh", folder)
        self.lips, self.eye = Net("lips", folder), Net("eye", folder)
        self.mean_face = read_array("mean_face.npy", folder).astype(np.float64)  # (478, 3) IOD
        self.mirror = read_array("mirror.npy", folder).astype(int)  # (478,) the other side's point
        parts = LIPS, EYE, self.mirror[EYE]
        self.close_points = np.concatenate(parts)
        self.far_points = np.setdiff1d(np.arange(POINTS), self.close_points)
        counts = [len(part) for part in parts]
        self._part = np.repeat([0, 1, 2], counts)  # of each close point: lips or which eye
        self._parts = np.split(np.arange(len(self.close_points)), np.cumsum(counts)[:-1])
        lips, *eyes = self._parts
        lids = np.flatnonzero(np.isin(EYE, EYE_CONTOUR))
        # rows: means of the lips, of both lid contours, and of the rims, which lids do not move
        of = (lips, *(eye[lids] for eye in eyes), *(eye[_RIMS] for eye in eyes))
        self._means = np.zeros((len(of), len(self.close_points)), np.complex128)
        for row, index in zip(self._means, of, strict=True):
            row[index] = 1 / len(index)
        mean_xy = self.mean_face[:, 0] + 1j * self.mean_face[:, 1]
        self._middle = complex(mean_xy.mean())
        centred = mean_xy - self._middle
        self._fit = centred.conj() / (centred * centred.conj()).real.sum()
        order = {int(point): at for at, point in enumerate(LIPS)}
        self._lips_mirror = np.array([order[int(self.mirror[point])] for point in LIPS])

    def face_frame(self, xy: np.ndarray) -> Similarity:
        """The frame of a face with these points (478,): a least-squares fit.

        The same as fit_similarity(mean_face, points), whose result is linear in the points.
        """
        turn = complex(self._fit @ xy)
        return Similarity(turn, complex(xy.sum()) / len(xy) - turn * self._middle)

    def detect(
        self, picture: Picture, side_px: int, threshold: float, tilt_degrees: float = 0
    ) -> list[tuple[float, Similarity]]:
        """(logit, face frame), surest first; the picture is seen with its longer side at side_px.

        tilt_degrees: how far the picture is turned for that; the detector knows heads that tilt
        up to 30 degrees or so.
        """
        wide, tall = picture.width_px, picture.height_px
        scale = max(wide, tall, 1) / side_px
        c, s = (f(math.radians(tilt_degrees)) for f in (math.cos, math.sin))
        w = max(round((abs(c) * wide + abs(s) * tall) / scale), 1)
        h = max(round((abs(s) * wide + abs(c) * tall) / scale), 1)
        turn = scale * complex(c, s)
        middle = complex(wide - 1, tall - 1) / 2 - turn * complex(w - 1, h - 1) / 2
        to_px = np.array(
            [[turn.real, -turn.imag, middle.real], [turn.imag, turn.real, middle.imag]]
        )
        padded_w, padded_h = (-(-side // _CELL_GROUP) * _CELL_GROUP for side in (w, h))
        seen = np.zeros((1, padded_h, padded_w, 3), np.uint8)
        seen[0, :h, :w] = picture.crop(to_px, (w, h)) if tilt_degrees else picture.whole((w, h))
        found = decode_cells(self.detector(seen)["cells"][0], threshold)
        seen_to_px = Similarity(turn, middle)
        return [(logit, seen_to_px.after(from_matrix(frame))) for logit, frame in found]

    def read_mesh(self, picture: Picture, frame: Similarity, mirrored: bool = False) -> Mesh:
        """All points, coarsely."""
        centre = middle_of(frame)
        to_px = np.array(_MESH.to_px(frame, centre, mirrored))
        out = self.mesh(picture.crop(to_px, _MESH.size_wh)[None])
        offsets = out["points"][0]
        if mirrored:
            offsets = offsets[self.mirror] * _MIRRORED
        face, mouth = out["scores"][0].tolist()
        z = offsets[:, 2].astype(np.float64) * iod_of(frame)
        return Mesh(_complex(offsets) * frame.turn + centre, z, (face, mouth))

    def middles(self, close_xy: np.ndarray) -> list[complex]:
        """The middles of lips, lids of either eye, and rim of either eye, of the close points (186,)."""
        middles: list[complex] = (self._means @ close_xy).tolist()
        return middles

    def view(self, xy: np.ndarray) -> View:
        """Where to look at a face with these points (478,)."""
        lips, left, right, *_ = self.middles(xy[self.close_points])
        return View(self.face_frame(xy), (lips, left, right))

    def look_closer(self, picture: Picture, view: View, both_ways: bool = False) -> Close:
        """Lips and eyes.

        both_ways: look at the mirrored lips too, and take the mean: truer, for more work.
        """
        frame, centres = view
        to_px = lips_to_px(view)[None]
        eyes_to_px = np.array([_EYE.to_px(frame, centres[1 + side], bool(side)) for side in (0, 1)])
        lips, eyes = picture.crops(((to_px, _LIPS.size_wh), (eyes_to_px, _EYE.size_wh)))
        offsets, logits = self._read_lips(lips, both_ways)
        found = self.eye(eyes)["points"]
        found[1, :, 0] *= -1  # it was seen mirrored
        xy = _complex(np.concatenate([offsets, *found])) * frame.turn
        xy += np.array(centres)[self._part]
        return Close(xy, LipPatch(logits, to_px[0]), self.middles(xy))

    def take_rest(self, xy: np.ndarray, z: np.ndarray, mesh: Mesh, strayed_px: float) -> bool:
        """Take, in place, from the mesh net's points all but lips and eyes; these too where they
        strayed.

        Where the rest hardly differs, only a part of the difference is taken: it is noise, and
        would jolt the face's pose. True when lips or eyes had strayed.
        """
        far, close = self.far_points, self.close_points
        off = (mesh.xy - xy)[far]
        share = 14 * float(np.abs(off.view(np.float64)).mean()) / max(strayed_px, 1e-9)
        share = min(max(share, _LEAST_SHARE), 1)
        xy[far] += share * off
        z[far] += share * (mesh.z - z)[far]
        z[close] = mesh.z[close]
        off, strayed = (xy - mesh.xy)[close], False
        for part in self._parts:
            if abs(complex(off[part].mean())) > strayed_px:
                xy[close[part]], strayed = mesh.xy[close[part]], True
        return strayed

    def _read_lips(self, crop: np.ndarray, both_ways: bool) -> tuple[np.ndarray, np.ndarray]:
        """(1, 80, 112, 3) uint8 -> points (80, 3) in IOD, logits (80, 112)."""
        if not both_ways:
            out = self.lips(crop)
            return out["points"][0], out["mask_logits"][0]
        out = self.lips(np.concatenate([crop, crop[:, :, ::-1]]))
        (offsets, mirrored), logits = out["points"], out["mask_logits"]
        offsets = (offsets + mirrored[self._lips_mirror] * _MIRRORED) / 2
        return offsets, (logits[0] + logits[1, :, ::-1]) / 2


def _complex(offsets: np.ndarray) -> np.ndarray:
    """A net's points (K, 3) -> (K,) complex128, x + iy."""
    xy = np.empty(len(offsets), np.complex128)
    xy.real, xy.imag = offsets[:, 0], offsets[:, 1]
    return xy


def decode_cells(cells: np.ndarray, threshold: float) -> list[tuple[float, AffineArray]]:
    """(6, rows, columns) of the detector -> (logit, face frame) in px of its picture, surest first.

    Per cell: the logit of a face, dx and dy to its middle in cells, the logarithm of its IOD in
    cells, cosine and sine of its turn.
    """
    logit = cells[0]
    rows, columns = np.nonzero(logit > math.log(threshold / (1 - threshold)))
    peak = cv2.dilate(logit, _AROUND)
    there = [(float(logit[at]), *at) for at in zip(rows.tolist(), columns.tolist(), strict=True)]
    found: list[tuple[float, AffineArray]] = []
    for told, row, column in sorted(there, key=lambda each: -each[0]):
        if told < peak[row, column]:
            continue
        dx, dy, size, cosine, sine = _told_around(cells, row, column).tolist()
        iod = math.exp(min(size, 8.0)) * _CELL
        turn = complex(cosine, sine) / max(abs(complex(cosine, sine)), 1e-6) * iod
        middle = (complex(column + dx, row + dy) + (0.5 + 0.5j)) * _CELL - (0.5 + 0.5j)
        if all(abs(middle_of(from_matrix(f)) - middle) > _CLOSE * iod for _, f in found):
            corner = middle - turn * complex(0, BELOW_EYES)
            linear = [turn.real, -turn.imag, corner.real], [turn.imag, turn.real, corner.imag]
            found.append((told, np.array(linear)))
    return found


def _told_around(cells: np.ndarray, row: int, column: int) -> np.ndarray:
    """(5,) what the cell of a large face tells, averaged with its neighbours, surer ones more.

    A small face's neighbours may belong to another, so its own cell speaks alone.
    """
    own = cells[1:, row, column]
    if own[2] < math.log(_LARGE_CELLS):
        return own
    down, across = cells.shape[1:]
    rows = slice(max(row - 1, 0), min(row + 2, down))
    columns = slice(max(column - 1, 0), min(column + 2, across))
    told = cells[1:, rows, columns].copy()
    told[0] += np.arange(columns.start - column, columns.stop - column)
    told[1] += np.arange(rows.start - row, rows.stop - row)[:, None]
    sure = 1 / (1 + np.exp(-cells[0, rows, columns]))
    mean: np.ndarray = (told * sure).sum((1, 2)) / sure.sum()
    return mean


@cache
def load_nets() -> FaceNets:
    """The nets of this process, loaded at first use. Raises InstallError."""
    return FaceNets()
