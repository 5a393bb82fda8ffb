"""Renders crops of people who wear drawn products, with R itself, as the reference net sees them.

    python -m makeup_video.training.reference.rendered_crops lips --data runs/reference.npz \\
        --shades lip_shades.csv --sheet runs/lips.png

R works on a small 4:4:4 frame around the region. Light is read from the whole portrait, once for
a few products.
"""

import argparse
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import av
import cv2
import numpy as np
from makeup_video.kernels.colour import matrices
from makeup_video.pipeline.faces.face import FrameFaces, moved
from makeup_video.pipeline.frames.frame import Frame, coding_of
from makeup_video.pipeline.frames.rgb import PICTURE_TAGS, PICTURE_TICK
from makeup_video.pipeline.frames.sampling import Affine, sample
from makeup_video.pipeline.frames.views import Crop, RgbPicture
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.regions import REGIONS
from makeup_video.pipeline.look.regions.eyes import ZONES
from makeup_video.pipeline.reference.crops import CROPS, crop_of, places_of, shifted, window_of
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.scene import FrameScene, SceneLight
from makeup_video.pipeline.render.scene_light import light_of
from makeup_video.training.reference.augment import camera, jpeg, lighting
from makeup_video.training.reference.draw_products import (
    Mixture,
    RealProducts,
    draw_settings,
    look_of,
    read_products,
)
from makeup_video.training.reference.people import People

MARGIN = 0.12  # of a crop's size, around it: what a misplaced crop shows
DETAIL = 0.9, 1.7  # px of the picture for one of the crop
LOOKS = 6  # products on one person in one light
# Crops are as far off as landmarks are: turn (radians), log scale, shift (share of the width).
JITTER = 0.02, 0.025, 0.007
SQUEEZE = 0.03  # log of width by height: a head that is turned a little more
LIGHT_ERROR = 0.03, 0.01  # of its log strength and log colour, as read from a photo
TEST_QUALITY = 90  # JPEG


def to_codes(rgb8: np.ndarray) -> np.ndarray:
    """(H, W, 3) uint8 R'G'B' -> Y'CbCr of a picture's frame, alike."""
    return cv2.transform(rgb8, _TO_CODES)


def to_rgb8(codes: np.ndarray) -> np.ndarray:
    return cv2.transform(codes, _TO_RGB)


def frame_of(codes: np.ndarray) -> Frame:
    """A new frame of (H, W, 3) Y'CbCr."""
    h, w = codes.shape[:2]
    frame = Frame(av.VideoFrame(w, h, "yuv444p"), 0, PICTURE_TICK, PICTURE_TAGS)
    for plane, part in zip(frame.writable_planes(), cv2.split(codes), strict=True):
        plane[:] = part
    return frame


_CODING = coding_of(frame_of(np.zeros((2, 2, 3), np.uint8)))
_TO_RGB, _TO_CODES = matrices(_CODING)[0] * 255, matrices(_CODING)[1] / [[255, 255, 255, 1]]


class Draws(Protocol):
    """Whatever draws products."""

    def draw(self, n: int, rng: np.random.Generator) -> np.ndarray: ...


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A bare person in some light, cut out around a region, or whole.

    codes: (H, W, 3) Y'CbCr.  scene: R's view of it; its frame is not painted on.  window: its px ->
    the cut's, None of a whole portrait.  places: the crop's px in the window, None too for eyes
    that are not seen.
    """

    codes: np.ndarray
    scene: FrameScene
    window: Crop | None = None
    places: np.ndarray | None = None

    @property
    def light(self) -> SceneLight:
        return self.scene.faces[0].light


def paint(composite: Composite, shot: Shot, look: Look) -> np.ndarray:
    """(H, W, 3) uint8: a shot with a look on; nothing outside the makeup differs between looks."""
    composite.set_look(look)
    frame = composite(replace(shot.scene, frame=frame_of(shot.codes)))
    return to_rgb8(cv2.merge(frame.planes))


class Renderer:
    """Paints drawn products on drawn people. The same seed gives the same pictures.

    varied: light, camera and placing vary as in photos; without, crops are in place, in the
    portrait's own light, and saved as JPEG 90.
    """

    def __init__(
        self, people: People, region: str, products: Draws, seed: int, varied: bool = True
    ) -> None:
        self.people, self.region, self.products, self.varied = people, region, products, varied
        self.rng = np.random.default_rng(seed)
        self._composite = Composite(Look())

    def shoot(self, person: int) -> Shot:
        """Cut out a person, in the portrait's light or another."""
        rgb8, face = self.people.rgb8(person), self.people.face(person)
        half = np.array([[0.5, 0, -0.25], [0, 0.5, -0.25]])  # enough to read light from
        size_wh = rgb8.shape[1] // 2, rgb8.shape[0] // 2
        whole = cv2.resize(rgb8, size_wh, interpolation=cv2.INTER_AREA)
        to_cut, cut_wh = self._cut(window_of(face, self.region))
        cut = sample(rgb8, cv2.invertAffineTransform(to_cut), cut_wh)
        if self.varied:
            gain = lighting(self.rng, size_wh)
            whole = _exposed(whole, gain)
            to_gain = cv2.invertAffineTransform(to_cut) * 0.5
            to_gain[:, 2] -= 0.25
            cut = _exposed(cut, sample(gain, to_gain, cut_wh))
        lights = light_of(FrameFaces(frame_of(to_codes(whole)), (moved(face, half),)))
        face, codes = moved(face, to_cut), to_codes(cut)
        scene = BuildScene().under(lights, FrameFaces(frame_of(codes), (face,)))
        return Shot(codes, scene, window_of(face, self.region), places_of(face, self.region))

    def _cut(self, window: Crop) -> tuple[Affine, tuple[int, int]]:
        """The part of a picture around a crop: picture px -> its px, and its size."""
        to_px, (w, h) = window
        more = MARGIN * w
        ends = to_px @ np.array([
            [-more, w + more, -more, w + more], [-more, -more, h + more, h + more], [1, 1, 1, 1],
        ])  # fmt: skip
        detail = self.rng.uniform(*DETAIL) if self.varied else 1.0
        scale = detail / abs(np.linalg.det(to_px[:, :2])) ** 0.5
        low, high = ends.min(1), ends.max(1)
        wide, high_px = np.ceil((high - low) * scale).astype(int).tolist()
        shift = (0.5 - low) * scale - 0.5
        return np.array([[scale, 0, shift[0]], [0, scale, shift[1]]]), (wide, high_px)

    def paint(self, shot: Shot, look: Look) -> np.ndarray:
        """(H, W, 3) uint8: the cut with a look on."""
        return paint(self._composite, shot, look)

    def see(self, shot: Shot, rgb8: np.ndarray) -> np.ndarray:
        """The crop that the net is shown of a cut, after a camera took it."""
        assert shot.window is not None, "a whole portrait has no crop"
        assert shot.places is not None, "prepare keeps no portrait whose lids are not seen"
        to_px, size_wh = shot.window
        light = shot.light
        if self.varied:
            rgb8, light = camera(rgb8, self.rng), self._misread(light)
            to_px = self._misplaced(shot.window)
        else:
            rgb8 = jpeg(rgb8, TEST_QUALITY)
        crop = crop_of(RgbPicture(rgb8).crop(to_px, size_wh), shot.places, light)
        return crop[:, ::-1] if self.varied and self.rng.random() < 0.5 else crop

    def _misread(self, light: SceneLight) -> SceneLight:
        colour = light.colour * np.exp(self.rng.normal(0, LIGHT_ERROR[1], 3)).astype(np.float32)
        strength = light.strength * np.exp(self.rng.normal(0, LIGHT_ERROR[0]))
        return replace(light, colour=colour, strength=float(strength))

    def _misplaced(self, window: Crop) -> Affine:
        turn, log_scale, off = JITTER
        squeeze = np.exp(-abs(self.rng.normal(0, SQUEEZE)))
        w, h = window[1]
        to_px = shifted(
            window, self.rng.normal(0, turn), float(np.exp(self.rng.normal(0, log_scale))),
            self.rng.normal(0, off * w, 2),
        )  # fmt: skip
        # a wider part of the picture: the face is narrower, as when the head is turned
        middle = to_px @ [(w - 1) / 2, (h - 1) / 2, 1]
        to_px[:, 0] /= squeeze
        to_px[:, 2] = middle - to_px[:, :2] @ [(w - 1) / 2, (h - 1) / 2]
        return to_px

    def zone(self) -> str:
        """Where eye-shadow goes is not told by the net: any."""
        return ZONES[self.rng.integers(len(ZONES))] if self.region == "eyes" else ZONES[0]

    def stream(self, looks: int = LOOKS) -> Iterator[tuple[np.ndarray, np.ndarray, int]]:
        """Crops (H, W, 3), the numbers (7,) of the product, and who wears it; without end."""
        while True:
            person = int(self.rng.choice(len(self.people), p=self.people.share))
            shot = self.shoot(person)
            for values in self.products.draw(looks, self.rng):
                settings = draw_settings(values, self.region, self.rng)
                painted = self.paint(shot, look_of(values, settings, self.region, self.zone()))
                yield self.see(shot, painted), values, person

    def batches(self, n: int, mix: int = 8) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Crops (n, H, W, 3) and numbers (n, 7); one person's crops go into several batches."""
        stream, (w, h) = self.stream(), CROPS[self.region].size_wh
        crops, values = np.empty((n * mix, h, w, 3), np.uint8), np.empty((n * mix, 7))
        while True:
            for at, (crop, numbers, _) in zip(range(n * mix), stream, strict=False):
                crops[at], values[at] = crop, numbers
            for part in self.rng.permutation(n * mix).reshape(mix, n):
                yield crops[part], values[part]


def _exposed(rgb8: np.ndarray, gain: np.ndarray) -> np.ndarray:
    return np.rint((rgb8 * gain).clip(0, 255)).astype(np.uint8)


def renderer(
    data: Path, shades: Path, region: str, split: str, seed: int, varied: bool = True
) -> Renderer:
    """People and products of one split: for training a mixture, else products never trained on."""
    products = read_products(shades, region)
    chosen: dict[str, Callable[[np.ndarray], Draws]] = {"train": Mixture}
    of = {"train": 0, "validation": 1, "test": 2}[split]
    draws = chosen.get(split, RealProducts)(products.values[products.split == of])
    return Renderer(People(data, region, split), region, draws, seed, varied)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("region", choices=REGIONS)
    parser.add_argument("--data", type=Path, default=Path("runs/reference.npz"))
    parser.add_argument("--shades", type=Path, required=True)
    parser.add_argument("--sheet", type=Path, help="a picture of 96 crops")
    options = parser.parse_args()
    os.environ.setdefault("POCL_MAX_PTHREAD_COUNT", "1")
    cv2.setNumThreads(1)
    one = renderer(options.data, options.shades, options.region, "train", seed=0)
    stream, count = one.stream(), 600
    crops = [next(stream)[0] for _ in range(96)]
    began, worked = time.time(), time.process_time()
    for _ in range(count):
        next(stream)
    worked, began = time.process_time() - worked, time.time() - began
    print(f"{count / began:.0f} crops/s, {1e3 * worked / count:.2f} ms CPU each")
    if options.sheet:
        rows = [np.hstack(crops[at : at + 12]) for at in range(0, 96, 12)]
        cv2.imwrite(str(options.sheet), np.vstack(rows)[..., ::-1])


if __name__ == "__main__":
    main()
