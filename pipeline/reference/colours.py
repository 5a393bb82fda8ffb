"""The colours of a face beside its skin, as a list of numbers, and what they tell of makeup.

A net sees shapes, such as a line along the lashes; colours beside plain skin tell makeup from the
shade of a brow or a flush more steadily (logistic regression on labelled photos,
training/worn/fit_colours.py). Both together are better than either.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.reference.cheeks import Cheeks, see_cheeks
from makeup_video.pipeline.reference.fit_lips import seen_lips
from makeup_video.pipeline.reference.flat_eyes import flat_eyes
from makeup_video.pipeline.reference.neutral_face import NeutralFace

# The flat eyes are averaged over blocks of so many cells.
BLOCKS, CELLS = (9, 8), (3, 6)
# What stands for a part that is not seen: about the median of bare faces.
_EYES, _LIPS, _CHEEKS = 0.7, 0.7, 1.0
_DARKEST = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Colours:
    """A face in neutral light, and its parts beside plain skin; None where a part is not seen.

    eyes: (27, 48, 3) as of flat_eyes.  lips: (3,) as of seen_lips.
    """

    neutral: NeutralFace
    eyes: np.ndarray | None
    lips: np.ndarray | None
    cheeks: Cheeks | None

    @classmethod
    def of(cls, neutral: NeutralFace) -> "Colours":
        return cls(neutral, flat_eyes(neutral), seen_lips(neutral), see_cheeks(neutral))

    def numbers(self) -> np.ndarray:
        """(226,) float64: logarithms of eyes by blocks, lips, cheeks and skin, and the skin's
        lightness squared."""
        eyes = np.full((*BLOCKS, 3), _EYES)
        if self.eyes is not None:
            (down, across), (high, wide) = BLOCKS, CELLS
            eyes = self.eyes.reshape(down, high, across, wide, 3).mean((1, 3))
        lips = np.full(3, _LIPS) if self.lips is None else self.lips
        cheeks = np.full(3, _CHEEKS) if self.cheeks is None else self.cheeks.mean()
        skin = np.log(self.neutral.skin)
        parts = np.concatenate([eyes.ravel(), lips, cheeks])
        return np.concatenate([np.log(np.maximum(parts, _DARKEST)), skin, [skin.mean() ** 2]])

    def log_odds(self) -> np.ndarray:
        """(4,) of what is worn, in the order of WORN."""
        weights = _weights()
        odds: np.ndarray = weights[:, :-1] @ self.numbers() + weights[:, -1]
        return odds


@lru_cache(maxsize=1)
def _weights() -> np.ndarray:
    """(4, 227): of each number, and a constant."""
    return read_array("worn_colours.npy").astype(np.float64)
