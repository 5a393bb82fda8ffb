"""FrameScene -> Frame: lays the look on the planes. Bytes outside every mask stay the decoder's."""

import math
from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.material import ENVIRONMENT_PX
from makeup_video.kernels.paint import Surface, paint
from makeup_video.kernels.planes import Window, fold, spread
from makeup_video.pipeline.device import open_device
from makeup_video.pipeline.eyes import EyeRegion
from makeup_video.pipeline.face import Face, iod_px
from makeup_video.pipeline.frame import Frame
from makeup_video.pipeline.lips import LipRegion
from makeup_video.pipeline.lit_product import Place, film_matrices, material
from makeup_video.pipeline.look import GraphicsParams, Look
from makeup_video.pipeline.scene import FaceScene, FrameScene, Lit, SceneLight

_LID_TO_FACE = 0.75  # luminance of lids in even light: the brow shades them
_ROOM_COLOUR = 0.4  # of what is reflected: a close-up's frame is mostly the face itself
_VEIL = 0.7  # of the room's mean light: what a reflection does not show
_MUCH_LARGER = 1.3  # areas

# Regions of a face that wear one product, the product, and how much of it.
_Part = tuple[tuple[Lit[LipRegion] | Lit[EyeRegion], ...], GraphicsParams, float]


class Composite:
    """Paints `look` on every frame.

    device: as for open_device.  faces: all, largest, or a face's number.
    painted_frames: how many frames had a face that was painted.
    Raises InstallError, UsageError for the device.
    """

    def __init__(self, look: Look, device: str = "", faces: str = "all") -> None:
        self._device = open_device(device)
        self._faces = faces
        self._largest_id = -1
        self.painted_frames = 0
        self.set_look(look)

    def set_look(self, look: Look) -> None:
        """Take effect from the next frame on."""
        self.look = look

    def __call__(self, item: FrameScene) -> Frame:
        look = self.look  # once: another thread may set one while this frame is painted
        chosen = [(scene, self._parts(scene, look)) for scene in self._chosen(item.faces)]
        chosen = [(scene, parts) for scene, parts in chosen if parts]
        if not chosen or len(item.frame.planes) < 2:  # a grey frame holds no colour
            return item.frame
        planes = item.frame.writable_planes()
        for scene, parts in chosen:
            for regions, params, amount in parts:
                environment = _environment(scene.light, params, item.coding)
                for lit in regions:
                    self._paint(item, planes, scene, lit, params, amount, look.zone, environment)
        self.painted_frames += 1
        return item.frame

    def _chosen(self, faces: tuple[FaceScene, ...]) -> tuple[FaceScene, ...]:
        if self._faces == "all":
            return faces
        if self._faces == "largest":
            return self._largest(faces)
        return tuple(scene for scene in faces if str(scene.face.track_id) == self._faces)

    def _largest(self, faces: tuple[FaceScene, ...]) -> tuple[FaceScene, ...]:
        """One at most. Of two of about a size the makeup would go to and fro: so it stays on a face
        until that is gone or another is much larger."""
        stays = [scene for scene in faces if scene.face.track_id == self._largest_id]
        if not stays or faces[0].face.area_px2 > _MUCH_LARGER * stays[0].face.area_px2:
            stays = list(faces[:1])
        if stays:
            self._largest_id = stays[0].face.track_id
        return tuple(stays[:1])

    def _parts(self, scene: FaceScene, look: Look) -> list[_Part]:
        parts: list[_Part] = []
        if look.lips and scene.lips and look.lips.is_worn:
            parts.append(((scene.lips,), look.lips, look.strength * scene.face.mouth_weight))
        if look.eyes and look.eyes.is_worn:
            parts.append((scene.eyes, look.eyes, look.strength * look.intensity))
        return [part for part in parts if part[0] and part[2] > 0]

    def _paint(
        self,
        item: FrameScene,
        planes: tuple[np.ndarray, ...],
        scene: FaceScene,
        lit: Lit[LipRegion] | Lit[EyeRegion],
        params: GraphicsParams,
        amount: float,
        zone: str,
        environment: np.ndarray,
    ) -> None:
        frame, region = item.frame, lit.region
        size = frame.width_px, frame.height_px
        low_xy, high_xy = region.reach(params.edge_softness, zone)
        window = Window.around(low_xy, high_xy, size, frame.chroma)
        if window is None:
            return
        maps = np.empty((4, window.height, window.width), np.float32)
        origin_xy = window.x, window.y
        region.weigh(maps[0], origin_xy, params.edge_softness, zone)
        to_window = region.grid.to_px.copy()
        to_window[:, 2] -= origin_xy
        for image, out in zip((lit.shading, *region.normals), maps[1:], strict=True):
            cv2.warpAffine(
                image, to_window, (window.width, window.height), out,
                flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE,
            )  # fmt: skip
        place = _place(scene.face, region)
        surface = Surface(maps, lit.mean, _to_skin(to_window, place), environment)
        light = _on_lids(scene.light, lit.mean) if isinstance(region, EyeRegion) else scene.light
        product = material(params, amount, light, place, item.coding, region.spared)
        chroma = window.chroma(planes, frame.chroma)
        change = spread(chroma, frame.chroma, (window.width, window.height))
        paint(self._device, window.luma(planes), change, surface, product, item.coding)
        fold(chroma, change, frame.chroma, item.coding.max_code)


def _on_lids(light: SceneLight, mean: float) -> SceneLight:
    """Lids are skin: where they are darker than the face, less light falls on them, by that much.

    So shadow stays shadow in deep-set eyes, and behind sunglasses nothing shines.
    """
    if light.skin <= 0:
        return light
    share = min(max(mean / (_LID_TO_FACE * light.skin), 0.05), 1.0)
    return replace(light, strength=light.strength * share)


def _place(face: Face, region: LipRegion | EyeRegion) -> Place:
    axes = region.grid.to_px[:, :2]
    return Place(axes / _lengths(axes), iod_px(face))


def _to_skin(to_window: np.ndarray, place: Place) -> np.ndarray:
    """(2, 3): px of a window -> the region's own axes, in units of the eyes' distance."""
    unit = _lengths(to_window[:, :2]) / place.skin_px
    back: np.ndarray = cv2.invertAffineTransform(to_window) * unit[:, None]
    return back


def _lengths(axes: np.ndarray) -> np.ndarray:
    """(2,) of the columns of (2, 2)."""
    (a, b), (c, d) = axes.tolist()
    return np.array([math.hypot(a, c), math.hypot(b, d)])


def _environment(light: SceneLight, params: GraphicsParams, coding: Coding) -> np.ndarray:
    """(3, 16, 16) float32: what the product mirrors, as blurred as it is told to be.

    What is as dark as the room's own average adds little: gloss shows windows and lamps, and an
    even room would only lay a veil over the colour.
    """
    blur = _blur(0.6 + 4 * params.environment_blur)
    grey = light.environment.mean(-1, keepdims=True)
    room = grey + _ROOM_COLOUR * (light.environment - grey)
    if coding.primaries != 1:  # products are mixed in sRGB's
        to_film = np.reshape(film_matrices(coding.primaries)[0], (3, 3)).astype(np.float32)
        room = room @ to_film.T
    blurred = blur @ np.moveaxis(room, -1, 0) @ blur.T
    bright: np.ndarray = np.maximum(blurred - _VEIL * blurred.mean((1, 2), keepdims=True), 0)
    return bright


@lru_cache
def _blur(sigma: float) -> np.ndarray:
    """(16, 16) float32: times the rows of an environment, these blurred; the border is repeated."""
    rows = np.eye(ENVIRONMENT_PX, dtype=np.float32)
    taps = cv2.getGaussianKernel(2 * math.ceil(4 * sigma) + 1, sigma, cv2.CV_32F)
    border = cv2.BORDER_REPLICATE
    return cv2.sepFilter2D(rows, -1, np.ones(1, np.float32), taps, borderType=border)
