"""Bare portraits as `prepare` packs them: pictures, faces, and how often each is drawn."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face, LipPatch
from makeup_video.training.reference.draw_products import SPLITS

MOST_OFTEN = 10.0  # times the median; otherwise a few people of a rare tone would dominate


class People:
    """The portraits of some splits that are bare in all the given regions.

    tone: (N,) bins of skin tone. share: (N,) how often to draw each portrait, so that all tones
    occur about equally often.
    """

    def __init__(self, path: Path, region: str | Sequence[str], *splits: str) -> None:
        regions = (region,) if isinstance(region, str) else region
        with np.load(path) as packed:
            chosen = np.isin(packed["split"], [SPLITS.index(split) for split in splits])
            for name in regions:
                chosen &= packed[f"bare_{name}"]
            ends, pictures = packed["ends"], packed["pictures"]
            starts = np.concatenate([[0], ends[:-1]])
            self._data = [pictures[starts[i] : ends[i]].copy() for i in np.flatnonzero(chosen)]
            columns = ("points", "logits", "to_px", "tone")
            self._points, self._logits, self._to_px, self.tone = (
                packed[c][chosen] for c in columns
            )
        weight = 1 / np.bincount(self.tone)[self.tone]
        weight = np.minimum(weight, MOST_OFTEN * np.median(weight))
        self.share = weight / weight.sum()

    def __len__(self) -> int:
        return len(self._data)

    def rgb8(self, person: int) -> np.ndarray:
        """(H, W, 3) uint8."""
        bgr8 = cv2.imdecode(self._data[person], cv2.IMREAD_COLOR)
        return cv2.cvtColor(bgr8, cv2.COLOR_BGR2RGB)

    def face(self, person: int) -> Face:
        """The face, as it was found in that picture."""
        patch = LipPatch(self._logits[person].astype(np.float32), self._to_px[person])
        return Face(self._points[person], 1.0, 1.0, 0, patch)
