"""The colours of a face compared with its plain skin, as numbers, and the makeup that they show.

A net sees shapes, such as a line along the lashes. Colours compared with plain skin separate makeup
from a brow's shadow or a flush more reliably, by logistic regression on labelled photos
(training/worn/fit_colours.py). Both together are better than either. Lipstick is detected from the
flat lips alone (flat_lips.py).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.reference.cheeks import Cheeks, see_cheeks
from makeup_video.pipeline.reference.fit_lips import lip_pixels
from makeup_video.pipeline.reference.flat_eyes import FlatEye, eyes_of, mean_eye
from makeup_video.pipeline.reference.flat_lips import FlatLips, flat_lips
from makeup_video.pipeline.reference.neutral_face import NeutralFace

# The flat eyes are averaged over blocks: rows and columns of blocks, and of cells in a block.
BLOCKS, CELLS = (9, 8), (3, 6)
# Areas of the eyes, in blocks: lid, crease, outer corner, under the eye.
_EYE_AREAS = (np.s_[4:6, 2:6], np.s_[2:4, 2:6], np.s_[3:6, 5:7], np.s_[6:8, 2:6])
_EYES = BLOCKS[0] * BLOCKS[1] * 3  # numbers of the eyes, which come first
# Roots that stand for a part that is not seen: about the median of bare faces.
_NO_EYES, _NO_LIPS, _NO_CHEEKS = 0.7, 0.7, 1.0
_DARKEST = 1e-3
_FURTHEST = 8.0  # beyond this distance from bare faces the square of the distance stays the same


@dataclass(frozen=True, slots=True, eq=False)
class Colours:
    """A face in neutral light, and its parts; None for a part that is not seen.

    each_eye: from eyes_of.  eyes: (27, 48, 3) from mean_eye.  lips: (N, 3) from lip_pixels.
    """

    neutral: NeutralFace
    each_eye: list[FlatEye]
    eyes: np.ndarray | None
    lips: np.ndarray | None
    cheeks: Cheeks | None
    flat_lips: FlatLips

    @classmethod
    def of(cls, neutral: NeutralFace) -> "Colours":
        each, lips, cheeks = eyes_of(neutral), lip_pixels(neutral), see_cheeks(neutral)
        return cls(neutral, each, mean_eye(each), lips, cheeks, flat_lips(neutral))

    def logarithms(self) -> np.ndarray:
        """(226,) float64: the logarithms of the face's colours.

        They are those of the eyes by blocks, of lips, cheeks and skin. The square of the skin's
        mean logarithm follows.
        """
        eyes = np.full((*BLOCKS, 3), _NO_EYES)
        if self.eyes is not None:
            (down, across), (high, wide) = BLOCKS, CELLS
            eyes = self.eyes.reshape(down, high, across, wide, 3).mean((1, 3))
        lips = np.full(3, _NO_LIPS)
        if self.lips is not None:
            lips = np.median(self.neutral.roots(self.lips), axis=0)
        cheeks = np.full(3, _NO_CHEEKS) if self.cheeks is None else self.cheeks.mean()
        skin = np.log(self.neutral.skin)
        parts = np.concatenate([eyes.ravel(), lips, cheeks])
        return np.concatenate([np.log(np.maximum(parts, _DARKEST)), skin, [skin.mean() ** 2]])

    def log_odds(self) -> np.ndarray:
        """(4,) log-odds that each kind is worn, in the order of WORN."""
        weights = _weights()
        numbers = with_distances(self.logarithms(), _bare())
        others = weights[:, :-1] @ numbers + weights[:, -1]
        return np.concatenate([[self.flat_lips.log_odds()], others])


def areas(logarithms: np.ndarray) -> np.ndarray:
    """Logarithms (..., 226) -> those of six areas, (..., 6, 3).

    The areas are lips, cheeks, lid, crease, outer corner, and under the eye.
    """
    blocks = logarithms[..., :_EYES].reshape(*logarithms.shape[:-1], *BLOCKS, 3)
    eyes = [blocks[(..., *area, slice(None))].mean((-3, -2)) for area in _EYE_AREAS]
    lips, cheeks = (logarithms[..., _EYES + at : _EYES + at + 3] for at in (0, 3))
    return np.stack([lips, cheeks, *eyes], -2)


def with_distances(logarithms: np.ndarray, bare: np.ndarray) -> np.ndarray:
    """Add each area's distance from bare faces, and its square: (..., 226) -> (..., 238).

    By these distances (Mahalanobis 1936) violet lips differ from bare ones, which may be red or
    brown. The squares are bounded, and divided by 4.
    bare: (6, 12), the median and the inverse covariance of each area on bare faces.
    """
    off = areas(logarithms) - bare[:, :3]
    inverse = bare[:, 3:].reshape(-1, 3, 3)
    away = np.sqrt(np.maximum(np.einsum("...ai,aij,...aj->...a", off, inverse, off), 0))
    squares = np.minimum(away, _FURTHEST) ** 2 / 4
    return np.concatenate([logarithms, away, squares], -1)


@lru_cache(maxsize=1)
def _weights() -> np.ndarray:
    """(3, 239): the weight of each number, and a constant, for all kinds but lipstick."""
    return read_array("worn_colours.npy").astype(np.float64)


@lru_cache(maxsize=1)
def _bare() -> np.ndarray:
    """(6, 12), as with_distances takes it."""
    return read_array("bare_colours.npy").astype(np.float64)
