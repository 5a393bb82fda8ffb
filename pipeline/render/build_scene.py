"""FrameFaces -> FrameScene: each face's lips and lids as surfaces, and the light on them."""

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.surface import SurfaceKernel
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.faces.track_memory import TrackMemory
from makeup_video.pipeline.frames.frame import Frame, coding_of
from makeup_video.pipeline.render.luminance import light_planes
from makeup_video.pipeline.render.opencl import open_device
from makeup_video.pipeline.render.regions.eyes import LID_RINGS, eye_places, eye_regions_of
from makeup_video.pipeline.render.regions.lips import LIP_RINGS, lip_place, lip_region_of
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.render.scene_light import EstimateLight

# A region's mean light follows as slowly as the light on the face does: so a shadow that passes
# is seen on the product at once, as on the skin.
_SETTLE_SECONDS = 0.5
_FORGET_SECONDS = 1.0
# Points around all that light is read for: borders of the lips, lash lines and brows.
_LIT = np.concatenate(
    [LIP_RINGS[::4, ::2].ravel(), LID_RINGS[::3, ::8].ravel(), LID_RINGS[2::3, ::4].ravel()]
)


class _Mean(NamedTuple):
    """The mean light of one region of a face, smoothed."""

    value: float
    last_seconds: float


class BuildScene:
    """Keeps, for each track, the light of its regions.

    device: as for open_device.  waits_for_nobody: with kernels of its own, which a thread of less
    priority cannot hold.  Raises InstallError, UsageError for the device.
    """

    def __init__(self, device: str = "", *, waits_for_nobody: bool = False) -> None:
        self._surface = _surface(device) if waits_for_nobody else _shared_surface(device)
        self._light = EstimateLight()
        self._means: TrackMemory[tuple[int, str], _Mean] = TrackMemory(_FORGET_SECONDS)

    def __call__(self, item: FrameFaces) -> FrameScene:
        return self.under(self._light(item), item)

    def under(self, lights: tuple[SceneLight, ...], item: FrameFaces) -> FrameScene:
        """The same when the light on each face is known."""
        frame = item.frame
        coding = coding_of(frame)
        if item.cut:
            self._means.clear()
        seconds = frame.seconds
        faces = tuple(
            self._face(frame, coding, face, light, seconds)
            for face, light in zip(item.faces, lights, strict=True)
        )
        self._means.forget(seconds)
        return FrameScene(frame, coding, faces)

    def _face(
        self, frame: Frame, coding: Coding, face: Face, light: SceneLight, seconds: float
    ) -> FaceScene:
        mouth, eyes = lip_place(face), eye_places(face)
        places = [place for place in (mouth, *eyes) if place]
        if not places:
            return FaceScene(face, light, None, ())
        planes = light_planes(frame, coding, places, face.points_px[_LIT].tolist())
        made = self._surface((mouth, *eyes), face.points_px, face.lips.logits, planes)
        lips = None
        if mouth:
            mean = self._smooth((face.track_id, "lips"), made.means[0], seconds)
            lips = Lit(lip_region_of(face, mouth, made), made.lips[0], mean)
        lids = []
        for number, region in enumerate(eye_regions_of(eyes, made)):
            if region:
                key = face.track_id, f"eye {number}"
                mean = self._smooth(key, made.means[1 + number], seconds)
                lids.append(Lit(region, made.lids[number, 2], mean))
        return FaceScene(face, light, lips, tuple(lids))

    def _smooth(self, key: tuple[int, str], mean: float, seconds: float) -> float:
        """The mean light of a region, smoothed by the frames' time."""
        before, last_seconds = self._means.get(key, _Mean(mean, seconds))
        since = seconds - last_seconds
        # no time since: a second face of one number
        share = 1 - math.exp(-since / _SETTLE_SECONDS) if 0 < since < _FORGET_SECONDS else 1.0
        smooth = before + share * (mean - before)
        self._means[key] = _Mean(smooth, seconds)
        return smooth


@cache
def _shared_surface(device: str) -> SurfaceKernel:
    """One for all threads: pictures that stand alone, and rendered ones, build a scene each."""
    return _surface(device)


def _surface(device: str) -> SurfaceKernel:
    rings = np.zeros((len(LIP_RINGS) + len(LID_RINGS), LIP_RINGS.shape[1]), np.int32)
    rings[: len(LIP_RINGS)] = LIP_RINGS
    rings[len(LIP_RINGS) :, : LID_RINGS.shape[1]] = LID_RINGS
    return SurfaceKernel(open_device(device), rings)
