"""The four nets: the detector finds faces; the mesh, lip and eye nets read their points.

All geometry is in upright px of a Picture, and points are complex numbers, x + iy. The *pose* of a
face is the similarity that lays the mean face, whose outer eye corners are 1 apart (the
inter-ocular distance, IOD), over the face. Every crop is turned and scaled by the pose, so the nets
always see an upright face of the same size. docs/models.md describes how each net was trained.
"""

import math
from collections.abc import Sequence
from functools import cache
from importlib.resources.abc import Traversable
from typing import NamedTuple

import cv2
import numpy as np
from makeup_video.pipeline.faces.crop_layout import (
    EYE_CROP,
    LIP_CROP,
    MESH_CROP,
    CropLayout,
    eye_crops,
    lip_patch_to_px,
    lips_reach,
    lips_widening,
)
from makeup_video.pipeline.faces.face import PATCH_SPAN, POINTS, LipPatch
from makeup_video.pipeline.faces.net import SHIPPED, Net, read_array
from makeup_video.pipeline.faces.shut_eyes import close_shut_eyes
from makeup_video.pipeline.faces.similarity import (
    BELOW_EYES,
    Similarity,
    iod_of,
    middle_of,
)
from makeup_video.pipeline.faces.topology import EYE, EYE_CONTOUR, LIPS
from makeup_video.pipeline.frames.views import Picture

_RIMS = slice(16, 48)  # of EYE: the two rings around the lids
_POSE_CENTRES = [0, 3, 4]  # of part_centres: lips and both eyes' rims
# How much a new mesh counts for the points outside lips and eyes: the least share, and how the
# share rises with the mean offset, in units of strayed_px (see merge_mesh). The rise was chosen by
# eye.
_LEAST_SHARE, _SHARE_RISE = 0.2, 14
_MIRRORED = np.array([-1, 1, 1])
_CELL = 8  # px of the detector's input per cell of its output
_SIDE_MULTIPLE = 32  # px: the sides of the detector's input are multiples of this
_NEIGHBOURS = np.ones((3, 3), np.uint8)
_LARGE_CELLS = 3.0  # IOD in cells from which on all neighbours of a face's cell show the same face
_LEAST_APART = 0.9  # IOD: two faces lie no closer than this


class Mesh(NamedTuple):
    """What the mesh net reads.

    xy: (478,) complex128 px. z: (478,) px.
    scores: the probabilities that this is a face, and that its mouth is visible.
    """

    xy: np.ndarray
    z: np.ndarray
    scores: tuple[float, float]


class Parts(NamedTuple):
    """What the lip and eye nets read.

    xy: (186,) complex128 px, the points `FaceNets.part_points`.
    lips: where lipstick goes; its to_px leads to upright px.
    centres: five, in px, see `FaceNets.part_centres`.
    """

    xy: np.ndarray
    lips: LipPatch
    centres: list[complex]


class FaceNets:
    """All four nets and the mean face, loaded once."""

    def __init__(self, folder: Traversable = SHIPPED) -> None:
        # The detector needs large blocks of memory. Without an arena the system would fill each new
        # block with zeros, which takes 1 ms a call.
        self.detector = Net("detector", folder, has_arena=True)
        self.mesh = Net("mesh", folder)
        self.lips, self.eye = Net("lips", folder), Net("eye", folder)
        self.mean_face = read_array("mean_face.npy", folder).astype(np.float64)  # (478, 3) IOD
        self.mirror = read_array("mirror.npy", folder).astype(int)  # (478,) mirror image of a point
        self._shut = read_array("shut_eyes.npy").astype(np.float64)  # fits the shipped nets
        parts = LIPS, EYE, self.mirror[EYE]
        self.part_points = np.concatenate(parts)
        self.rest_points = np.setdiff1d(np.arange(POINTS), self.part_points)
        counts = [len(part) for part in parts]
        self._part_of_point = np.repeat([0, 1, 2], counts)  # lips, left eye or right eye
        self._parts = np.split(np.arange(len(self.part_points)), np.cumsum(counts)[:-1])
        lips, *eyes = self._parts
        lids = np.flatnonzero(np.isin(EYE, EYE_CONTOUR))
        groups = (lips, *(eye[lids] for eye in eyes), *(eye[_RIMS] for eye in eyes))
        self._means = np.zeros((len(groups), len(self.part_points)), np.complex128)
        for row, group in zip(self._means, groups, strict=True):
            row[group] = 1 / len(group)
        mean_xy = self.mean_face[:, 0] + 1j * self.mean_face[:, 1]
        self._middle = complex(mean_xy.mean())
        centred = mean_xy - self._middle
        self._fit = centred.conj() / (centred * centred.conj()).real.sum()
        mean_centres = np.array(self.part_centres(mean_xy[self.part_points]))[_POSE_CENTRES]
        self._middle_of_centres = complex(mean_centres.mean())
        centred = mean_centres - self._middle_of_centres
        self._fit_centres = (centred.conj() / (centred * centred.conj()).real.sum()).tolist()
        order = {int(point): index for index, point in enumerate(LIPS)}
        self._lips_mirror = np.array([order[int(self.mirror[point])] for point in LIPS])

    def fit_pose(self, xy: np.ndarray) -> Similarity:
        """The pose of a face with these points (478,): a least-squares fit of the mean face."""
        turn = complex(self._fit @ xy)
        return Similarity(turn, complex(xy.sum()) / len(xy) - turn * self._middle)

    def detect(
        self, picture: Picture, side_px: int, threshold: float, tilt_degrees: float = 0
    ) -> list[tuple[float, Similarity]]:
        """Finds faces: (logit, pose) of each, surest first.

        side_px: the longer side of the detector's input. tilt_degrees: by how much the picture is
        turned first; the detector finds heads that tilt up to about 30 degrees.
        """
        wide, tall = picture.width_px, picture.height_px
        scale = max(wide, tall, 1) / side_px
        c, s = (f(math.radians(tilt_degrees)) for f in (math.cos, math.sin))
        w = max(round((abs(c) * wide + abs(s) * tall) / scale), 1)
        h = max(round((abs(s) * wide + abs(c) * tall) / scale), 1)
        turn = scale * complex(c, s)
        middle = complex(wide - 1, tall - 1) / 2 - turn * complex(w - 1, h - 1) / 2
        to_px = Similarity(turn, middle)
        padded_w, padded_h = (-(-side // _SIDE_MULTIPLE) * _SIDE_MULTIPLE for side in (w, h))
        rgb8 = np.zeros((1, padded_h, padded_w, 3), np.uint8)
        rgb8[0, :h, :w] = (
            picture.crop(to_px.array(), (w, h)) if tilt_degrees else picture.whole((w, h))
        )
        found = decode_cells(self.detector(rgb8)["cells"][0], threshold)
        return [(logit, to_px.after(pose)) for logit, pose in found]

    def read_mesh(self, picture: Picture, pose: Similarity, mirrored: bool = False) -> Mesh:
        """Reads all points, coarsely. mirrored: from the mirror image of the crop."""
        centre = middle_of(pose)
        to_px = np.array(MESH_CROP.to_px(pose, centre, mirrored))
        out = self.mesh(picture.crop(to_px, MESH_CROP.size_wh)[None])
        offsets = out["points"][0]
        if mirrored:
            offsets = offsets[self.mirror] * _MIRRORED
        face, mouth = out["scores"][0].tolist()
        z = offsets[:, 2].astype(np.float64) * iod_of(pose)
        return Mesh(_complex(offsets) * pose.turn + centre, z, (face, mouth))

    def part_centres(self, part_xy: np.ndarray) -> list[complex]:
        """Five means of the part points (186,): lips, both lid contours, and both eyes' rims.

        The order is lips, left lids, right lids, left rim, right rim. Moving lids leave the rims
        where they are.
        """
        centres: list[complex] = (self._means @ part_xy).tolist()
        return centres

    def crop_layout(self, xy: np.ndarray) -> CropLayout:
        """Where the crops of a face with these points (478,) lie."""
        part_xy = xy[self.part_points]
        lips, left, right, *_ = self.part_centres(part_xy)
        pose = self.fit_pose(xy)
        return CropLayout(pose, (lips, left, right), self.widening(part_xy, pose))

    def layout_around(self, centres: Sequence[complex], widening: float = 0.0) -> CropLayout:
        """Where the crops of a face with these `part_centres` lie."""
        of_pose = [centres[index] for index in _POSE_CENTRES]
        turn = sum(a * b for a, b in zip(self._fit_centres, of_pose, strict=True))
        middle = sum(of_pose) / len(of_pose)
        lips, left, right, *_ = centres
        pose = Similarity(turn, middle - turn * self._middle_of_centres)
        return CropLayout(pose, (lips, left, right), widening)

    def layout_that_holds(self, parts: "Parts", widening: float, most: float) -> CropLayout:
        """A layout around these parts whose lip crop holds the lips, if any crop is wide enough.

        most: how far the lips may reach, as a share of the way to the crop's border. widening: of
        these parts.
        """
        layout = self.layout_around(parts.centres, widening).rounded()
        if self.lips_reach(parts.xy, layout) > most:
            layout = self.layout_around(parts.centres, math.ceil(widening)).rounded()
        return layout

    def widening(self, part_xy: np.ndarray, pose: Similarity) -> float:
        """`lips_widening` of the part points (186,)."""
        return lips_widening(part_xy[self._parts[0]], pose)

    def lips_reach(self, part_xy: np.ndarray, layout: CropLayout) -> float:
        """`lips_reach` of the part points (186,)."""
        return lips_reach(part_xy[self._parts[0]], layout)

    def read_parts(
        self, picture: Picture, layout: CropLayout, with_mirrored: bool = False
    ) -> Parts:
        """Reads the points of lips and eyes, precisely, and where lipstick goes.

        with_mirrored: read the mirrored lips too, and take the mean: more precise, for more work.
        """
        pose, centres, _ = layout
        to_px = lip_patch_to_px(layout)[None]
        lips, eyes = picture.crops(((to_px, LIP_CROP.size_wh), eye_crops(layout)))
        lip_offsets, logits = self._read_lips(lips, with_mirrored)
        eye_offsets = self.eye(eyes)["points"]
        close_shut_eyes(eye_offsets, eyes, self._shut, EYE_CROP.span)
        eye_offsets[1, :, 0] *= -1  # the crop of the right eye is mirrored
        lip_offsets *= layout.lip_span / PATCH_SPAN
        xy = _complex(np.concatenate([lip_offsets, *eye_offsets])) * pose.turn
        xy += np.array(centres)[self._part_of_point]
        patch = LipPatch(logits, to_px[0], layout.lip_span)
        return Parts(xy, patch, self.part_centres(xy))

    def merge_mesh(self, xy: np.ndarray, z: np.ndarray, mesh: Mesh, strayed_px: float) -> bool:
        """Moves the points towards those of the mesh, in place.

        Lips and eyes are moved only if they strayed by more than strayed_px. The other points are
        moved by a share of the difference if it is small: a small difference is noise, and would
        jolt the face's pose. Returns True when lips or eyes had strayed.
        """
        rest, parts = self.rest_points, self.part_points
        off = (mesh.xy - xy)[rest]
        share = _SHARE_RISE * float(np.abs(off.view(np.float64)).mean()) / max(strayed_px, 1e-9)
        share = min(max(share, _LEAST_SHARE), 1)
        xy[rest] += share * off
        z[rest] += share * (mesh.z - z)[rest]
        z[parts] = mesh.z[parts]
        off, strayed = (xy - mesh.xy)[parts], False
        for part in self._parts:
            if abs(complex(off[part].mean())) > strayed_px:
                xy[parts[part]], strayed = mesh.xy[parts[part]], True
        return strayed

    def _read_lips(self, crop: np.ndarray, with_mirrored: bool) -> tuple[np.ndarray, np.ndarray]:
        """(1, 80, 112, 3) uint8 -> points (80, 3) in IOD, logits (80, 112)."""
        if not with_mirrored:
            out = self.lips(crop)
            return out["points"][0], out["mask_logits"][0]
        out = self.lips(np.concatenate([crop, crop[:, :, ::-1]]))
        (offsets, mirrored), logits = out["points"], out["mask_logits"]
        offsets = (offsets + mirrored[self._lips_mirror] * _MIRRORED) / 2
        return offsets, (logits[0] + logits[1, :, ::-1]) / 2


def _complex(offsets: np.ndarray) -> np.ndarray:
    """Points as a net gives them, (K, 3) -> (K,) complex128, x + iy."""
    xy = np.empty(len(offsets), np.complex128)
    xy.real, xy.imag = offsets[:, 0], offsets[:, 1]
    return xy


def decode_cells(cells: np.ndarray, threshold: float) -> list[tuple[float, Similarity]]:
    """(6, rows, columns) of the detector -> (logit, pose) in px of its input, surest first.

    A cell holds the logit of a face, dx and dy to the face's centre in cells, the logarithm of the
    IOD in cells, and cosine and sine of the turn. threshold: the least probability of a face.
    """
    logits = cells[0]
    rows, columns = np.nonzero(logits > math.log(threshold / (1 - threshold)))
    peaks = cv2.dilate(logits, _NEIGHBOURS)
    places = zip(rows.tolist(), columns.tolist(), strict=True)
    candidates = [(float(logits[place]), *place) for place in places]
    found: list[tuple[float, Similarity]] = []
    for logit, row, column in sorted(candidates, key=lambda candidate: -candidate[0]):
        if logit < peaks[row, column]:
            continue
        dx, dy, size, cosine, sine = _cell_values(cells, row, column).tolist()
        iod = math.exp(min(size, 8.0)) * _CELL
        turn = complex(cosine, sine) / max(abs(complex(cosine, sine)), 1e-6) * iod
        middle = (complex(column + dx, row + dy) + (0.5 + 0.5j)) * _CELL - (0.5 + 0.5j)
        if all(abs(middle_of(pose) - middle) > _LEAST_APART * iod for _, pose in found):
            found.append((logit, Similarity(turn, middle - turn * complex(0, BELOW_EYES))))
    return found


def _cell_values(cells: np.ndarray, row: int, column: int) -> np.ndarray:
    """(5,) values of a cell; for a large face, their mean over the neighbours, too, by probability.

    The neighbours of a small face's cell may belong to another face, so they do not count.
    """
    own = cells[1:, row, column]
    if own[2] < math.log(_LARGE_CELLS):
        return own
    down, across = cells.shape[1:]
    rows = slice(max(row - 1, 0), min(row + 2, down))
    columns = slice(max(column - 1, 0), min(column + 2, across))
    values = cells[1:, rows, columns].copy()
    values[0] += np.arange(columns.start - column, columns.stop - column)
    values[1] += np.arange(rows.start - row, rows.stop - row)[:, None]
    probability = 1 / (1 + np.exp(-cells[0, rows, columns]))
    mean: np.ndarray = (values * probability).sum((1, 2)) / probability.sum()
    return mean


@cache
def load_nets() -> FaceNets:
    """The nets of this process, loaded at first use. Raises InstallError."""
    return FaceNets()
