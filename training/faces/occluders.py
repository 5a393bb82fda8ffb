"""Draws things in front of a face, and things that only look like a face.

All are drawn in face units (IOD), with the origin between the eyes, x to the right and y down, so
that a mask lies over a mouth. The same hands, ovals and scrambled faces also occur without a face:
the detector must not take them for one.
"""

from collections.abc import Callable

import cv2
import numpy as np
from makeup_video.training.faces.augment import light

Colour = np.ndarray  # (3,) encoded RGB, 0 to 255
REACH = 3.0  # IOD around the origin that an occluder may cover
FINE = 4  # fractional bits of drawing coordinates


class Canvas:
    """The part of a scene around a face, and what is painted there in face units."""

    def __init__(self, scene: np.ndarray, face: np.ndarray, rng: np.random.Generator) -> None:
        """scene (H, W, 3) uint8; face (4,): centre x, y, IOD px, turn in radians."""
        self.rng = rng
        x, y, unit, turn = face
        h, w = scene.shape[:2]
        low = np.clip([x - REACH * unit, y - REACH * unit], 0, [w - 1, h - 1]).astype(int)
        high = np.clip([x + REACH * unit, y + REACH * unit], low + 1, [w, h]).astype(int)
        self.target = scene[low[1] : high[1], low[0] : high[0]]
        c, s = np.cos(turn) * unit, np.sin(turn) * unit
        self.linear, self.unit = np.array([[c, -s], [s, c]]), unit
        self.origin = np.array([x, y]) - self.linear @ [0, 0.42] - low
        self.skin = self._skin(scene, face)
        self.paint = np.zeros(self.target.shape, np.uint8)
        self.mask = np.zeros(self.target.shape[:2], np.uint8)

    def _skin(self, scene: np.ndarray, face: np.ndarray) -> Colour:
        x, y = (face[:2] + self.linear @ [self.rng.choice([-0.4, 0.4]), 0.0]).astype(int)
        h, w = scene.shape[:2]
        return scene[np.clip(y, 0, h - 1), np.clip(x, 0, w - 1)].astype(float)

    def place(self, points: np.ndarray) -> np.ndarray:
        """(K, 2) face units -> drawing coordinates (fixed point)."""
        at = np.asarray(points, float) @ self.linear.T + self.origin
        return np.rint(at.clip(-2000, 2000) * 2**FINE).astype(np.int32)

    def polygon(self, points: np.ndarray, colour: Colour) -> None:
        corners = [self.place(points)]
        cv2.fillPoly(self.paint, corners, colour.clip(0, 255).tolist(), cv2.LINE_AA, FINE)
        cv2.fillPoly(self.mask, corners, 255, cv2.LINE_AA, FINE)

    def oval(self, centre: np.ndarray, axes: tuple[float, float], colour: Colour) -> None:
        angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        self.polygon(centre + np.stack([np.cos(angle), np.sin(angle)], 1) * axes, colour)

    def bar(self, a: np.ndarray, b: np.ndarray, thick: float, colour: Colour) -> None:
        """A bar with round ends, `thick` IOD wide."""
        ends = [tuple(end.tolist()) for end in self.place(np.stack([a, b]))]
        width = max(1, round(thick * self.unit))
        cv2.line(self.paint, *ends, colour.clip(0, 255).tolist(), width, cv2.LINE_AA, FINE)
        cv2.line(self.mask, *ends, 255, width, cv2.LINE_AA, FINE)

    def finish(self, texture: np.ndarray | None = None) -> None:
        """Blend the painting into the scene, often lit unevenly. texture: colours used instead."""
        h, w = self.mask.shape
        paint = self.paint if texture is None else cv2.resize(texture, (w, h))
        lit = paint * np.sqrt(light(self.rng, w, h)) if self.rng.random() < 0.6 else paint
        mask = cv2.GaussianBlur(self.mask, (0, 0), self.rng.uniform(0.4, 1.0))
        weight = mask[..., None].astype(np.float32) / 255
        mixed = self.target + weight * (lit - self.target.astype(np.float32))
        self.target[:] = mixed.clip(0, 255)


def colour(rng: np.random.Generator) -> Colour:
    """A random colour; black, white and greys are more frequent than by chance."""
    if rng.random() < 0.4:
        return np.full(3, rng.uniform(0, 255)) + rng.normal(size=3) * 6
    return rng.uniform(0, 255, 3)


def hand(canvas: Canvas, centre: np.ndarray | None = None) -> None:
    """A palm and up to five fingers, skin-coloured, shaded at their edges."""
    rng = canvas.rng
    if centre is None:  # mouth, chin, cheek or brow
        centre = np.array([rng.normal() * 0.5, rng.choice([0.85, 0.9, 1.0, 0.4, -0.3])])
    skin = canvas.skin * rng.uniform(0.7, 1.2)
    towards = rng.uniform(0, 2 * np.pi)
    size = rng.uniform(0.7, 1.2)
    away = np.array([np.cos(towards), np.sin(towards)])
    palm = centre - away * 0.45 * size
    canvas.bar(palm - away * rng.uniform(0.8, 2.5), palm, 0.45 * size, skin * 0.95)
    canvas.oval(palm, (0.36 * size, 0.36 * size), skin)
    spread, count = rng.uniform(0.02, 0.25), int(rng.integers(2, 6))
    for finger in range(count):
        angle = towards + (finger - (count - 1) / 2) * spread
        sideways = np.array([-away[1], away[0]]) * (finger - (count - 1) / 2) * 0.17 * size
        long = size * rng.uniform(0.5, 0.95)
        tip = palm + sideways + long * np.array([np.cos(angle), np.sin(angle)])
        canvas.bar(palm + sideways, tip, 0.19 * size, skin * rng.uniform(0.55, 0.8))
        canvas.bar(palm + sideways, tip, 0.15 * size, skin * rng.uniform(0.9, 1.1))


def surgical_mask(canvas: Canvas) -> None:
    rng = canvas.rng
    top, side = rng.uniform(0.15, 0.5), rng.uniform(0.7, 0.85)
    shade = colour(rng)
    for x in (-1, 1):
        canvas.bar(np.array([x * side, top + 0.2]), np.array([x * 0.95, 0.1]), 0.03, shade)
    canvas.polygon(
        [[-side, top + 0.15], [0, top], [side, top + 0.15], [side * 0.85, 0.9], [0.3, 1.3],
         [-0.3, 1.3], [-side * 0.85, 0.9]], shade,
    )  # fmt: skip
    for y in np.linspace(top + 0.25, 1.1, int(rng.integers(0, 4))):
        ends = np.array([[-side * 0.9, y], [side * 0.9, y]])
        canvas.bar(*ends, 0.02, shade * rng.uniform(0.7, 1.1))


def microphone(canvas: Canvas) -> None:
    rng = canvas.rng
    head = np.array([rng.normal() * 0.4, rng.uniform(0.6, 1.2)])
    foot = head + np.array([rng.normal() * 0.8, rng.uniform(0.8, 2)])
    canvas.bar(head, foot, rng.uniform(0.1, 0.25), colour(rng) * 0.6)
    canvas.oval(head, tuple(rng.uniform(0.15, 0.4, 2)), colour(rng) * 0.6)


def hat(canvas: Canvas) -> None:
    rng = canvas.rng
    brim, wide, shade = rng.uniform(-0.5, -0.12), rng.uniform(0.8, 1.1), colour(rng)
    high = brim - rng.uniform(0.5, 1.2)
    canvas.polygon([[-wide, brim], [-wide * 0.9, high], [wide * 0.9, high], [wide, brim]], shade)
    if rng.random() < 0.6:
        out = wide * rng.uniform(1, 1.5)
        ends = np.array([[-out, brim], [out, brim + rng.normal() * 0.1]])
        canvas.bar(*ends, rng.uniform(0.08, 0.25), shade * rng.uniform(0.6, 1.1))


def glasses(canvas: Canvas) -> None:
    rng = canvas.rng
    shade, axes = colour(rng) * rng.uniform(0.1, 0.8), tuple(rng.uniform([0.22, 0.14], [0.36, 0.3]))
    canvas.bar(np.array([-0.8, -0.05]), np.array([0.8, -0.05]), 0.05, shade)
    for x in (-0.33, 0.33):
        canvas.oval(np.array([x, 0.03]), axes, shade)


def hair(canvas: Canvas) -> None:
    """A curtain of strands over one side or over the brow."""
    rng = canvas.rng
    shade = np.array([60, 40, 25]) * rng.uniform(0.1, 3.5)
    side, inner = rng.choice([-1, 1]), rng.uniform(0.0, 0.6)
    for _ in range(int(rng.integers(6, 18))):
        x = side * rng.uniform(inner, 1.1)
        ends = np.array([[x * 0.7, -0.8], [x + rng.normal() * 0.1, rng.uniform(-0.2, 1.8)]])
        canvas.bar(*ends, rng.uniform(0.04, 0.25), shade * rng.uniform(0.7, 1.3))


def board(canvas: Canvas) -> None:
    """A cup, a phone, a book: an upright or tilted box."""
    rng = canvas.rng
    centre = np.array([rng.normal() * 0.5, rng.choice([0.9, 1.0, 0.6, -0.5])])
    half, turn = rng.uniform(0.2, 0.7, 2), rng.normal() * 0.4
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    c, s = np.cos(turn), np.sin(turn)
    canvas.polygon(centre + corners @ np.array([[c, s], [-s, c]]), colour(rng))


COVERS: tuple[Callable[[Canvas], None], ...] = (
    hand, hand, hand, surgical_mask, microphone, hat, hat, glasses, hair, board,
)  # fmt: skip


def cover(scene: np.ndarray, face: np.ndarray, rng: np.random.Generator) -> None:
    """Hide part of a face, in place; face as in Canvas."""
    canvas = Canvas(scene, face, rng)
    kind = COVERS[int(rng.integers(len(COVERS)))]
    kind(canvas)
    textured = kind not in (hand, glasses) and rng.random() < 0.25
    canvas.finish(scene if textured else None)


def blot_out(scene: np.ndarray, face: np.ndarray, rng: np.random.Generator) -> None:
    """Replace a face, in place: by an oval, the back of a head, or shuffled pieces."""
    canvas = Canvas(scene, face, rng)
    kind = rng.random()
    if kind < 0.4:
        shuffle(canvas)
        return
    shade = canvas.skin if kind < 0.75 else np.array([60, 40, 25]) * rng.uniform(0.1, 3.5)
    canvas.oval(np.array([0, 0.35]), (0.92, 1.2), shade)
    if kind < 0.6:
        for _ in range(int(rng.integers(3, 12))):  # folds and shadows
            ends = rng.uniform([-0.8, -0.6], [0.8, 1.3], (2, 2))
            canvas.bar(*ends, rng.uniform(0.05, 0.3), shade * rng.uniform(0.7, 1.15))
    canvas.finish()


def shuffle(canvas: Canvas) -> None:
    """Cut the face into tiles smaller than an eye, and shuffle them."""
    side = max(3, round(0.22 * canvas.unit))
    low = np.maximum(np.rint(canvas.origin + canvas.linear @ [0, 0.35] - canvas.unit), 0)
    x, y = low.astype(int)
    part = canvas.target[y : y + round(2.3 * canvas.unit), x : x + round(2 * canvas.unit)]
    rows, columns = part.shape[0] // side, part.shape[1] // side
    if rows * columns < 4:
        canvas.oval(np.array([0, 0.35]), (0.92, 1.2), canvas.skin)
        canvas.finish()
        return
    part = part[: rows * side, : columns * side]
    tiles = part.reshape(rows, side, columns, side, 3).swapaxes(1, 2).reshape(-1, side, side, 3)
    tiles = tiles[canvas.rng.permutation(len(tiles))]
    tiles = tiles.reshape(rows, columns, side, side, 3).swapaxes(1, 2)
    part[:] = tiles.reshape(part.shape)


def decoy(scene: np.ndarray, skin: Colour, rng: np.random.Generator) -> None:
    """Draw a hand, an arm or a skin-coloured oval where no face is, in place."""
    h, w = scene.shape[:2]
    unit = np.exp(rng.uniform(np.log(6), np.log(100)))
    place = np.array([*rng.uniform([0, 0], [w, h]), unit, rng.uniform(-np.pi, np.pi)])
    canvas = Canvas(scene, place, rng)
    canvas.skin = skin * rng.uniform(0.7, 1.2)
    kind = rng.random()
    if kind < 0.5:
        hand(canvas, rng.normal(size=2) * 0.3)
    elif kind < 0.75:
        ends = rng.normal(size=(2, 2))
        canvas.bar(*ends, rng.uniform(0.3, 0.9), canvas.skin)
    else:
        canvas.oval(np.zeros(2), tuple(rng.uniform(0.4, 1.2, 2)), canvas.skin)
    canvas.finish()
