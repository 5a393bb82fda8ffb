"""Lays the lips flat, with the skin around them, and reads from them whether lipstick is worn.

A column is a place along the lips. A row is a share of a lip's height: first of the upper lip, from
the skin above to the opening, then of the lower lip, from the opening to the skin below. So colour,
borders and evenness of different mouths can be compared cell by cell. A logistic model of these
numbers (training/worn/fit_colours.py) distinguishes lipstick from a flush better than one colour
for all of the lips does.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.faces.topology import MOUTH_CORNERS
from makeup_video.pipeline.frames.sampling import remap
from makeup_video.pipeline.reference.neutral_face import NeutralFace
from makeup_video.pipeline.render.surfaces.lips import LIP_RINGS

COLUMNS = 16
# The outer and the inner contour of each lip, between the corners of the mouth: (2, 11) points.
_UPPER, _LOWER = LIP_RINGS[[0, 3]], LIP_RINGS[[4, 7]]
# The rows of one lip, in shares of its height from the outer contour: on the skin, and on the lip.
_ROWS = np.concatenate([np.linspace(-0.9, -0.1, 5), np.linspace(0.08, 0.92, 7)])
_LEAST_HEIGHT = 0.13  # in widths of the mouth; rows on the skin treat thinner lips as this high
_BLUR_PX = 0.7  # sigma, px of the neutral face
_DARKEST = 0.03  # least root
# Blocks of cells: their rows on one lip, and their columns on one half of the mouth.
_BLOCKS = (slice(0, 2), slice(2, 5), slice(5, 7), slice(7, 10), slice(10, 12))
_HALVES = (slice(0, 3), slice(3, 5), slice(5, 8))
# Blocks in the middle of the mouth: outer and inner of the upper lip, then of the lower lip.
_MIDDLES = (8, 11, 23, 26)
_LIPS = slice(5, 19)  # rows that lie on the lips
_BORDERS = (slice(1, 8), slice(16, 23))  # rows around the upper and the lower border
# Rows of a lip near its border, and further in; and the columns away from the corners.
_OUTER, _INNER, _MIDDLE_COLUMNS = slice(5, 7), slice(8, 11), slice(4, 12)


@dataclass(frozen=True, slots=True, eq=False)
class FlatLips:
    """The lips of a face, laid flat.

    roots: (24, 16, 3), of shares of skin.  shape: (3,) heights of the opening, of the upper and of
    the lower lip, in widths of the mouth.
    """

    roots: np.ndarray
    shape: np.ndarray

    def numbers(self) -> np.ndarray:
        """(102,) float64: numbers by which mouths are compared, the same for the mirror image.

        For each block lightness and two differences of channels; then how uneven the lips are, how
        sharp their borders are, and their shape.
        """
        logs = np.log(np.maximum((self.roots + self.roots[:, ::-1]) / 2, _DARKEST))
        rows24 = [*_BLOCKS, *(slice(24 - rows.stop, 24 - rows.start) for rows in _BLOCKS)]
        blocks = np.array([logs[rows, half].mean((0, 1)) for rows in rows24 for half in _HALVES])
        red, green, blue = blocks.T
        lips = logs[_LIPS]
        hues = lips[..., 0] - lips[..., 1], lips[..., 2] - lips[..., 1]
        redness, lightness = logs[..., 0] - logs[..., 1], logs.mean(-1)
        return np.concatenate([
            np.stack([blocks.mean(1), red - green, blue - green], 1).ravel(),
            lips.std((0, 1)), [hue.std() for hue in hues],
            [_sharpness(part[rows]) for part in (redness, lightness) for rows in _BORDERS],
            self.shape,
        ])  # fmt: skip

    def log_odds(self) -> float:
        """Log-odds that lipstick is worn, for colours of labelled faces; none is blue or green."""
        weights = _weights()
        return float(weights[:-1] @ self.numbers() + weights[-1])

    def away(self) -> float:
        """How far the lips are from bare ones; see away_from_bare."""
        return away_from_bare(self.numbers(), _bare())

    def bands(self) -> np.ndarray:
        """(2, 3) the mean roots of both lips: near their borders, and further in."""
        rows24 = self.roots[:, _MIDDLE_COLUMNS].mean(1)
        rows12 = (rows24[:12] + rows24[:11:-1]) / 2
        return np.stack([rows12[_OUTER].mean(0), rows12[_INNER].mean(0)])


def middles(numbers: np.ndarray) -> np.ndarray:
    """Numbers of lips (..., 102) -> (..., 4, 3), the blocks in the middle of both lips."""
    return np.stack([numbers[..., 3 * block : 3 * block + 3] for block in _MIDDLES], -2)


def away_from_bare(numbers: np.ndarray, bare: np.ndarray) -> float:
    """The distance that three of the four middle blocks have at least from bare lips.

    That is the second smallest of the four distances (Mahalanobis 1936): the fourth block may be a
    highlight or a shadow.
    numbers: (102,).  bare: (4, 12), the median and the inverse covariance of each block.
    """
    off, inverse = middles(numbers) - bare[:, :3], bare[:, 3:].reshape(-1, 3, 3)
    squares = np.einsum("bi,bij,bj->b", off, inverse, off)
    return float(np.sqrt(max(np.sort(squares)[1], 0.0)))


def flat_lips(neutral: NeutralFace) -> FlatLips:
    """The lips of a face in neutral light."""
    soft = cv2.GaussianBlur(neutral.linear, (0, 0), _BLUR_PX)
    points = neutral.face.points_px[:, :2].astype(np.float32)
    left, right = points[list(MOUTH_CORNERS)]
    width = float(np.linalg.norm(left - right))
    lines = [[_line(points[ids]) for ids in lip] for lip in (_UPPER, _LOWER)]
    upper, lower = (_lip(soft, outer, inner, width) for outer, inner in lines)
    gaps = [lines[0][1], lines[1][1]], lines[0], lines[1]
    shape = [np.linalg.norm(one - other, axis=1).mean() / width for one, other in gaps]
    return FlatLips(neutral.roots(np.concatenate([upper, lower[::-1]])), np.array(shape))


def _line(contour: np.ndarray) -> np.ndarray:
    """(11, 2) points of a contour -> (16, 2) places along it, away from the corners."""
    at = np.linspace(0.6, 9.4, COLUMNS)
    return np.stack([np.interp(at, np.arange(11), contour[:, axis]) for axis in (0, 1)], 1)


def _lip(linear: np.ndarray, outer: np.ndarray, inner: np.ndarray, width: float) -> np.ndarray:
    """(12, 16, 3): a lip and the skin beyond its outer contour."""
    inward = inner - outer
    height = np.linalg.norm(inward, axis=1, keepdims=True)
    on_skin = inward / np.maximum(height, 1e-3) * np.maximum(height, _LEAST_HEIGHT * width)
    rows = _ROWS[:, None, None]
    places = (outer + rows * np.where(rows < 0, on_skin, inward)).astype(np.float32)
    return remap(linear, places.reshape(-1, 2).T).reshape(len(_ROWS), COLUMNS, 3)


def _sharpness(border: np.ndarray) -> float:
    """The mean over the columns of the largest step between rows."""
    return float(np.abs(np.diff(border, axis=0)).max(0).mean())


@lru_cache(maxsize=1)
def _weights() -> np.ndarray:
    """(103,): the weight of each number, and a constant."""
    return read_array("worn_lips.npy").astype(np.float64)


@lru_cache(maxsize=1)
def _bare() -> np.ndarray:
    """(4, 12), as away_from_bare takes it."""
    return read_array("bare_lips.npy").astype(np.float64)
