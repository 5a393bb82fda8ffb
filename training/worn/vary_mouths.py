"""Varies mouths, for the net that reads how lipstick shines: draws the highlights of wet lips.

The gloss that we paint is smooth. On real lips the folds break highlights into bright strips and
specks with sharp edges. The wetter the lips, the brighter and sharper the highlights.
"""

import cv2
import numpy as np
from makeup_video.pipeline.reference.read_lipstick import MOUTH_WH
from makeup_video.training.worn.mouth import Mouth
from makeup_video.training.worn.vary_photos import heights, moved, photographed

_SHINY_SHARE = 0.45  # how often lips that are hardly glossy get highlights
_HARDLY_GLOSSY = 1.3
# The gloss that a person saw in 160 mouths: _LEAST_SEEN, and up to _MORE_SEEN more the wetter a
# mouth was drawn (a correlation of 0.87).
_LEAST_SEEN, _MORE_SEEN = 0.85, 1.85
_FINER = 2  # px of a drawing per px of the picture
_COARSEST, _CONTRAST = 0.65, (0.9, 1.15)  # beyond these, lips would look more or less wet
_CENTRE = (np.array(MOUTH_WH) - 1) / 2


def varied(mouth: Mouth, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A mouth as another photo shows it, (80, 112, 3) uint8, and its target, (2,) float32."""
    rgb8, target, contours = mouth
    if target[0] < _HARDLY_GLOSSY and rng.random() < _SHINY_SHARE:
        wet = rng.random()
        rgb8 = _lit(rgb8, highlights(contours, wet, rng), rng)
        target = np.float32([max(target[0], _LEAST_SEEN + _MORE_SEEN * wet), target[1]])
    if rng.random() < 0.5:
        rgb8 = rgb8[:, ::-1]
    seen = moved(np.ascontiguousarray(rgb8), _CENTRE, rng)
    return photographed(seen, rng, _COARSEST, _CONTRAST), target


def highlights(contours: np.ndarray, wet: float, rng: np.random.Generator) -> np.ndarray:
    """(80, 112) float32: the share of each pixel that highlights hide, 0..1.

    contours: as in Mouth.  wet: 0 for a soft sheen, 1 for lips that are soaked.
    """
    x, y = _axis(MOUTH_WH[0]), _axis(MOUTH_WH[1])[:, None]
    left, right = contours[0, :, 0].min(), contours[0, :, 0].max()
    along = (x - left) / max(float(right - left), 1.0)
    edges = [heights(contour, x) for contour in contours]
    folds = _noise((1, len(x)), 0, rng.uniform(0.4, 1.15), rng)[0]
    lit_from = 0.5 + rng.normal(0, 0.13)  # where along the mouth the lips mirror the light
    drawing = np.zeros((len(y), len(x)), np.float32)
    for is_upper, outer, inner in ((True, *edges[:2]), (False, *edges[2:])):
        height = np.maximum(np.abs(inner - outer), 1.5)
        inward = (y - outer) * (1 if is_upper else -1) / height
        near = _near(along, inward, lit_from, is_upper, rng)
        # the folds of the lips fan out
        column = np.arange(len(x)) + (inward - 0.5) * (along - 0.5) * len(x) / 4
        broken = near + rng.uniform(0, 0.9) * folds[np.clip(column, 0, len(x) - 1).astype(int)]
        broken += rng.uniform(0.2, 0.9) * _noise(near.shape, 0.65, 0.4, rng)
        sharpness = 2 / (0.12 + 0.9 * (1 - wet))
        light = 1 / (1 + np.exp(-np.clip(sharpness * (broken + 0.4), -30, 30)))
        light *= np.exp(np.minimum(near + 2.5, 0))  # nothing shines far from a highlight
        on_lips = np.clip(inward * height / 0.8 + 1, 0, 1)
        on_lips *= np.clip((1 - inward) * height / 0.8 + 0.3, 0, 1)
        drawing = np.maximum(drawing, light * on_lips * ((along > 0.03) & (along < 0.97)))
    strength = min(0.12 + 0.95 * wet * rng.uniform(0.75, 1.15), 1.0)
    soft = cv2.GaussianBlur(np.float32(strength * drawing), (0, 0), 0.27 * _FINER)
    return cv2.resize(soft, MOUTH_WH, interpolation=cv2.INTER_AREA)


def _near(
    along: np.ndarray,
    inward: np.ndarray,
    lit_from: float,
    is_upper: bool,
    rng: np.random.Generator,
) -> np.ndarray:
    """How near each place of a lip is to a place that mirrors the light. The number is highest in
    the middle of each highlight, 0.4 at most.

    along: the place along the mouth, as a share of its width.  inward: the distance from the lip's
    outer border, as a share of its height.
    """
    near = np.full(inward.shape, -9.0, np.float32)
    for _ in range(rng.integers(1, 4)):
        if is_upper and rng.random() < 0.4:  # along the border
            at, high = rng.uniform(-0.12, 0.06), 0.07
        elif is_upper:
            at, high = rng.uniform(0.05, 0.6), rng.uniform(0.06, 0.22)
        else:
            at, high = rng.uniform(0.25, 0.7), rng.uniform(0.08, 0.28)
        aside = rng.choice([-1, 1]) * rng.uniform(0, 0.22) if is_upper else rng.normal(0, 0.1)
        wide = rng.uniform(0.03, 0.14) if is_upper else rng.uniform(0.05, 0.2)
        bright = rng.uniform(-0.8, 0.3) if is_upper else rng.uniform(-0.2, 0.4)
        x = along - lit_from - aside
        y = inward - at - 1.2 * rng.uniform(-0.3, 1.2) * x * x
        near = np.maximum(near, bright - (x / wide) ** 2 - (y / high) ** 2)
    return near


def _lit(rgb8: np.ndarray, share: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The picture with nearly white highlights; share: (H, W), their share of each pixel."""
    white = 255 * np.clip(rng.normal(0.95, 0.06, 3), 0.7, 1)
    lit = rgb8 + share[..., None] * np.maximum(white - rgb8, 0)
    coded: np.ndarray = np.rint(lit).astype(np.uint8)
    return coded


def _noise(
    shape: tuple[int, ...], down: float, across: float, rng: np.random.Generator
) -> np.ndarray:
    """Noise of standard deviation 1, blurred by the sigmas down and across, px of the picture."""
    sigmas = {"sigmaX": across * _FINER, "sigmaY": max(down * _FINER, 1e-3)}
    noise = cv2.GaussianBlur(rng.normal(0, 1, shape).astype(np.float32), (0, 0), **sigmas)
    scaled: np.ndarray = noise / noise.std()
    return scaled


def _axis(length_px: int) -> np.ndarray:
    """Where the pixels of a drawing lie along one side, in px of the picture."""
    return (np.arange(length_px * _FINER) + 0.5) / _FINER - 0.5
