"""Opens mouths further in training crops, so that the border of the opening is known exactly.

Masks of real mouths are uncertain by a pixel or two where lips meet teeth, gum, tongue or the dark.
So an opening is drawn a little larger, over the lips, and filled with what another mouth shows
between its lips. The border of that opening is exact by construction.
"""

import cv2
import numpy as np

LEAST_PX = 40  # an opening with fewer px has too little to show
SURE = 230  # of 255; px with more of the opening surely lie within it
KEPT_TEXTURES = 300
WIDER_PX = (0.4, 3.2)  # range by which an opening grows
LIP_LEFT_PX = 1.5  # width of lip that stays beside a wider opening


class Openings:
    """Remembers what recent mouths show between their lips, and draws it into others."""

    def __init__(self, rng: np.random.Generator, chance: float = 0.35) -> None:
        self.rng, self.chance = rng, chance
        self._textures: list[np.ndarray] = []

    def remember(self, rgb8: np.ndarray, opening: np.ndarray, teeth: np.ndarray) -> None:
        """Keep the inside of an opening as a texture with the channels R, G, B and teeth.

        opening, teeth: (H, W) uint8, as in Batch.
        """
        inside = cv2.erode((opening > SURE).astype(np.uint8), np.ones((3, 3), np.uint8))
        if inside.sum() < LEAST_PX:
            return
        x, y, w, h = cv2.boundingRect(inside)
        part = np.s_[y : y + h, x : x + w]
        texture = without_gaps(np.dstack([rgb8, teeth])[part], inside[part] > 0)
        if len(self._textures) < KEPT_TEXTURES:
            self._textures.append(texture)
        else:
            self._textures[int(self.rng.integers(KEPT_TEXTURES))] = texture

    def __call__(self, rgb8: np.ndarray, mask: np.ndarray) -> np.ndarray:
        """The crop, now and then with a mouth that is open wider; its mask is changed in place.

        mask: (H, W, 4), as in Batch.
        """
        rng, (whole, opening, teeth, _) = self.rng, np.moveaxis(mask, -1, 0)
        self.remember(rgb8, opening, teeth)
        if not self._textures or (opening > 127).sum() < LEAST_PX or rng.random() > self.chance:
            return rgb8
        wider = widened(whole, opening, rng)
        x, y, w, h = cv2.boundingRect((wider > 0.01).astype(np.uint8))
        if not w:  # the labeller may have marked an opening, but no mouth around it
            return rgb8
        texture = self._textures[int(rng.integers(len(self._textures)))]
        if rng.random() < 0.5:
            texture = texture[:, ::-1]
        filled = np.zeros((*opening.shape, 4), np.float32)
        part = np.s_[y : y + h, x : x + w]
        filled[part] = cv2.resize(texture, (w, h), interpolation=cv2.INTER_LINEAR)
        shade = shade_of_lips(wider, rng) * np.float32(2 ** rng.normal(0, 0.35))
        filled[..., :3] *= shade[..., None]
        share = np.rint(wider * 255).astype(np.uint8)
        weight = share[..., None] / np.float32(255)
        drawn = rgb8 + weight * (filled[..., :3] - rgb8)
        mask[..., 2] = np.rint(teeth + weight[..., 0] * (filled[..., 3] - teeth)).astype(np.uint8)
        mask[..., 1] = np.maximum(opening, share)
        return np.rint(drawn).clip(0, 255).astype(np.uint8)


def without_gaps(picture: np.ndarray, known: np.ndarray) -> np.ndarray:
    """A picture with every px outside `known` (H, W) bool replaced by the nearest known px."""
    _, labels = cv2.distanceTransformWithLabels(
        (~known).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    of_label = np.zeros((int(labels.max()) + 1, picture.shape[-1]), picture.dtype)
    of_label[labels[known]] = picture[known]
    filled: np.ndarray = of_label[labels]
    return filled


def widened(whole: np.ndarray, opening: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(H, W) float32: the share of every px that a wider opening covers, within the mouth."""
    away = cv2.distanceTransform((opening <= 127).astype(np.uint8), cv2.DIST_L2, 5)
    bends = rng.normal(1, 0.35, (4, 5)).astype(np.float32)
    bends = cv2.resize(bends, opening.shape[::-1], interpolation=cv2.INTER_CUBIC)
    grown = np.float32(rng.uniform(*WIDER_PX)) * bends - away + 0.5
    to_skin = cv2.distanceTransform((whole > 127).astype(np.uint8), cv2.DIST_L2, 5)
    edge = np.float32(rng.uniform(0.6, 1.6))  # px, of the soft border
    return np.minimum(grown, to_skin - LIP_LEFT_PX).clip(0, edge) / edge


def shade_of_lips(opening: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(H, W) float32 gain: lips, the upper one above all, shade what lies just behind them."""
    down = cv2.GaussianBlur(opening, (0, 0), rng.uniform(0.8, 4))
    down = cv2.warpAffine(
        down, np.float32([[1, 0, 0], [0, 1, rng.uniform(0, 3)]]), opening.shape[::-1]
    )
    gain: np.ndarray = 1 - np.float32(rng.uniform(0, 0.9)) * (1 - down)
    return gain
