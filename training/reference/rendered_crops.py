"""Renders crops of people who wear drawn products, as inputs of the reference nets.

    python -m makeup_video.training.reference.rendered_crops lips --data runs/reference.npz \\
        --shades lip_shades.csv --sheet runs/lips.png

Our renderer paints a small 4:4:4 frame around the region. The light is read from the whole
portrait, once for every few drawn products.
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
from makeup_video.pipeline.frames.affine import AffineArray, compose, invert
from makeup_video.pipeline.frames.frame import Frame, coding_of
from makeup_video.pipeline.frames.rgb import PICTURE_TAGS, PICTURE_TICK
from makeup_video.pipeline.frames.sampling import sample
from makeup_video.pipeline.frames.views import Crop, RgbPicture
from makeup_video.pipeline.look.look import ZONES, Look
from makeup_video.pipeline.reference.crops import (
    CROPPED,
    CROPS,
    crop_around,
    input_places,
    net_input,
)
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.scene import FrameScene, SceneLight
from makeup_video.pipeline.render.scene_light import light_of
from makeup_video.training.faces.augment import jpeg
from makeup_video.training.inputs import existing, made_by
from makeup_video.training.reference.augment import camera, lighting
from makeup_video.training.reference.draw_products import (
    SPLITS,
    Mixture,
    RealProducts,
    draw_settings,
    look_of,
    read_products,
)
from makeup_video.training.reference.people import People

MARGIN = 0.12  # around a crop, in its widths: a misplaced crop shows some of that
DETAIL = 0.9, 1.7  # px of the rendered part per px of the crop
LOOKS = 6  # products painted on one person in one light
# One sigma of the error of landmarks: turn (radians), log scale, shift (share of the width).
JITTER = 0.02, 0.025, 0.007
SQUEEZE = 0.03  # one sigma of the log of width by height, as if the head were turned slightly more
LIGHT_ERROR = 0.03, 0.01  # one sigma of log strength and log colour, as read from a photo
TEST_QUALITY = 90  # of JPEG


def to_codes(rgb8: np.ndarray) -> np.ndarray:
    """(H, W, 3) uint8 R'G'B' -> (H, W, 3) uint8 Y'CbCr, as tagged by PICTURE_TAGS."""
    return cv2.transform(rgb8, _TO_CODES)


def to_rgb8(codes: np.ndarray) -> np.ndarray:
    """The inverse of to_codes."""
    return cv2.transform(codes, _TO_RGB)


def frame_of(codes: np.ndarray) -> Frame:
    """A new frame of (H, W, 3) uint8 Y'CbCr."""
    h, w = codes.shape[:2]
    frame = Frame(av.VideoFrame(w, h, "yuv444p"), 0, PICTURE_TICK, PICTURE_TAGS)
    for plane, part in zip(frame.writable_planes(), cv2.split(codes), strict=True):
        plane[:] = part
    return frame


_CODING = coding_of(frame_of(np.zeros((2, 2, 3), np.uint8)))
_TO_RGB, _TO_CODES = matrices(_CODING)[0] * 255, matrices(_CODING)[1] / [[255, 255, 255, 1]]


class Draws(Protocol):
    """Draws products: (n, 7) numbers."""

    def draw(self, n: int, rng: np.random.Generator) -> np.ndarray: ...


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A bare person in some light: the part around a region, or the whole portrait.

    codes: (H, W, 3) uint8 Y'CbCr.
    scene: the renderer's input; its own frame is never painted.
    crop: the crop of the region, in px of the part; None for a whole portrait.
    places: where in the crop each pixel of the net's input lies; None for a whole portrait, and for
    eyes that cannot be seen.
    """

    codes: np.ndarray
    scene: FrameScene
    crop: Crop | None = None
    places: np.ndarray | None = None

    @property
    def light(self) -> SceneLight:
        return self.scene.faces[0].light


def paint(composite: Composite, shot: Shot, look: Look) -> np.ndarray:
    """The shot with a look on, (H, W, 3) uint8.

    Outside the makeup, the pictures of all looks are the same.
    """
    composite.set_look(look)
    frame = composite(replace(shot.scene, frame=frame_of(shot.codes)))
    return to_rgb8(cv2.merge(frame.planes))


class Renderer:
    """Paints drawn products on drawn people. The same seed gives the same pictures.

    varied: light, camera and the place of crops vary as in photos. Otherwise crops are in place, in
    the portrait's own light, and compressed as JPEG 90.
    """

    def __init__(
        self, people: People, region: str, products: Draws, seed: int, varied: bool = True
    ) -> None:
        self.people, self.region, self.products, self.varied = people, region, products, varied
        self.rng = np.random.default_rng(seed)
        self._composite = Composite(Look())

    def shoot(self, person: int) -> Shot:
        """The part of a portrait around the region, in the portrait's light or another."""
        rgb8, face = self.people.rgb8(person), self.people.face(person)
        half = np.array([[0.5, 0, -0.25], [0, 0.5, -0.25]])  # half size, enough to read the light
        size_wh = rgb8.shape[1] // 2, rgb8.shape[0] // 2
        whole = cv2.resize(rgb8, size_wh, interpolation=cv2.INTER_AREA)
        to_part, part_wh = self._part(crop_around(face, self.region))
        part = sample(rgb8, invert(to_part), part_wh)
        if self.varied:
            gain = lighting(self.rng, size_wh)
            whole = _exposed(whole, gain)
            to_gain = invert(to_part) * 0.5
            to_gain[:, 2] -= 0.25
            part = _exposed(part, sample(gain, to_gain, part_wh))
        lights = light_of(FrameFaces(frame_of(to_codes(whole)), (moved(face, half),)))
        face, codes = moved(face, to_part), to_codes(part)
        scene = BuildScene().under(lights, FrameFaces(frame_of(codes), (face,)))
        return Shot(codes, scene, crop_around(face, self.region), input_places(face, self.region))

    def _part(self, crop: Crop) -> tuple[AffineArray, tuple[int, int]]:
        """The part of a picture around a crop: the map picture px -> part px, and its size."""
        to_px, (w, h) = crop
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
        """The shot with a look on, (H, W, 3) uint8."""
        return paint(self._composite, shot, look)

    def see(self, shot: Shot, rgb8: np.ndarray) -> np.ndarray:
        """The input of the net from a painted shot, after a camera took it."""
        assert shot.crop is not None, "a whole portrait has no crop"
        assert shot.places is not None, "prepare keeps no portrait whose lids are not seen"
        to_px, size_wh = shot.crop
        light = shot.light
        if self.varied:
            rgb8, light = camera(rgb8, self.rng), self._misread(light)
            to_px = self._misplaced(shot.crop)
        else:
            rgb8 = jpeg(rgb8, TEST_QUALITY)
        rgb8 = net_input(RgbPicture(rgb8).crop(to_px, size_wh), shot.places, light)
        return rgb8[:, ::-1] if self.varied and self.rng.random() < 0.5 else rgb8

    def _misread(self, light: SceneLight) -> SceneLight:
        colour = light.colour * np.exp(self.rng.normal(0, LIGHT_ERROR[1], 3)).astype(np.float32)
        strength = light.strength * np.exp(self.rng.normal(0, LIGHT_ERROR[0]))
        return replace(light, colour=colour, strength=float(strength))

    def _misplaced(self, crop: Crop) -> AffineArray:
        turn, log_scale, off = JITTER
        squeeze = np.exp(-abs(self.rng.normal(0, SQUEEZE)))
        w, h = crop[1]
        to_px = shifted(
            crop, self.rng.normal(0, turn), float(np.exp(self.rng.normal(0, log_scale))),
            self.rng.normal(0, off * w, 2),
        )  # fmt: skip
        # The crop takes in more width, so the face becomes narrower, as when the head is turned.
        middle = to_px @ [(w - 1) / 2, (h - 1) / 2, 1]
        to_px[:, 0] /= squeeze
        to_px[:, 2] = middle - to_px[:, :2] @ [(w - 1) / 2, (h - 1) / 2]
        return to_px

    def zone(self) -> str:
        """A random zone: the net does not read where eyeshadow goes."""
        return ZONES[self.rng.integers(len(ZONES))] if self.region == "eyes" else ZONES[0]

    def stream(self, looks: int = LOOKS) -> Iterator[tuple[np.ndarray, np.ndarray, int]]:
        """Endless inputs (H, W, 3), numbers (7,) of the product, and the person who wears it."""
        while True:
            person = int(self.rng.choice(len(self.people), p=self.people.share))
            shot = self.shoot(person)
            for values in self.products.draw(looks, self.rng):
                settings = draw_settings(values, self.region, self.rng)
                painted = self.paint(shot, look_of(values, settings, self.region, self.zone()))
                yield self.see(shot, painted), values, person

    def batches(self, n: int, mix: int = 8) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Endless inputs (n, H, W, 3) and numbers (n, 7); a person is spread over `mix` batches."""
        stream, (w, h) = self.stream(), CROPS[self.region].input_wh
        crops, values = np.empty((n * mix, h, w, 3), np.uint8), np.empty((n * mix, 7))
        while True:
            for index, (crop, numbers, _) in zip(range(n * mix), stream, strict=False):
                crops[index], values[index] = crop, numbers
            for part in self.rng.permutation(n * mix).reshape(mix, n):
                yield crops[part], values[part]


def shifted(crop: Crop, turn: float, scale: float, shift_xy: np.ndarray) -> AffineArray:
    """The map of a crop that is turned (radians), scaled and shifted (crop px) about its centre."""
    to_px, (w, h) = crop
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    linear, middle = np.array([[c, -s], [s, c]]), np.array([(w - 1) / 2, (h - 1) / 2])
    return compose(to_px, np.column_stack([linear, middle + shift_xy - linear @ middle]))


def _exposed(rgb8: np.ndarray, gain: np.ndarray) -> np.ndarray:
    return np.rint((rgb8 * gain).clip(0, 255)).astype(np.uint8)


def renderer(
    data: Path, shades: Path, region: str, split: str, seed: int, varied: bool = True
) -> Renderer:
    """The renderer of a split: with a mixture of products for training, else with products never
    trained on."""
    products = read_products(shades, region)
    chosen: dict[str, Callable[[np.ndarray], Draws]] = {"train": Mixture}
    of_split = products.values[products.split == SPLITS.index(split)]
    draws = chosen.get(split, RealProducts)(of_split)
    return Renderer(People(data, region, split), region, draws, seed, varied)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("region", choices=CROPPED)
    parser.add_argument("--data", type=made_by("reference.prepare"), default="runs/reference.npz")
    parser.add_argument("--shades", type=existing, required=True)
    parser.add_argument("--sheet", type=Path, help="write a picture of 96 crops here")
    options = parser.parse_args()
    os.environ.setdefault("POCL_MAX_PTHREAD_COUNT", "1")
    cv2.setNumThreads(1)
    source = renderer(options.data, options.shades, options.region, "train", seed=0)
    stream, count = source.stream(), 600
    crops = [next(stream)[0] for _ in range(96)]
    began, worked = time.time(), time.process_time()
    for _ in range(count):
        next(stream)
    worked, began = time.process_time() - worked, time.time() - began
    print(f"{count / began:.0f} crops/s, {1e3 * worked / count:.2f} ms CPU each")
    if options.sheet:
        rows = [np.hstack(crops[first : first + 12]) for first in range(0, 96, 12)]
        cv2.imwrite(str(options.sheet), np.vstack(rows)[..., ::-1])


if __name__ == "__main__":
    main()
