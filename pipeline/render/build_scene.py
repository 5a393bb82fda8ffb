"""FrameFaces -> FrameScene: each face's lips and lids as surfaces, and the light on them."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.surface import FaceSurfaces, GridPlace, SurfaceKernel
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.faces.track_memory import TrackMemory
from makeup_video.pipeline.frames.frame import Frame, coding_of
from makeup_video.pipeline.render.light_planes import light_planes
from makeup_video.pipeline.render.opencl import once_a_process, open_device
from makeup_video.pipeline.render.regions import READ
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.render.scene_light import EstimateLight
from makeup_video.pipeline.render.softness import softness_of
from makeup_video.pipeline.render.surfaces.eyes import (
    EYE_CURVES,
    FOLD_CURVE,
    LASH_CURVE,
    LID_RINGS,
)
from makeup_video.pipeline.render.surfaces.lips import LIP_RINGS
from makeup_video.pipeline.render.surfaces.region import SeenFace

# Time constant of a region's mean light, the same as of the light on the face. The mean hardly
# changes in a passing shadow, so the shadow is seen on the product at once, as on the skin.
_SETTLE_SECONDS = 0.5
_FORGET_SECONDS = 1.0  # a region unseen for longer starts with a new mean
# Points around all places whose light counts: the lips' borders, the eyes' corners and the folds
# above them. `light_planes` adds a margin.
_LIT = np.concatenate(
    [
        LIP_RINGS[::4, ::2].ravel(),
        *(eye[LASH_CURVE][::8] for eye in EYE_CURVES),
        *(eye[FOLD_CURVE][::4] for eye in EYE_CURVES),
    ]
)


class _Mean(NamedTuple):
    """The mean light of one region of a face, smoothed."""

    value: float
    last_seconds: float


class BuildScene:
    """FrameFaces -> FrameScene; keeps the mean light of each track's regions.

    device: see open_device.  exclusive: use kernel objects of its own, so that a thread of lower
    priority cannot block this one.  Raises as open_device does.
    """

    def __init__(self, device: str = "", *, exclusive: bool = False) -> None:
        self._surface = _surface(device) if exclusive else _shared_surface(device)
        self._light = EstimateLight()
        self._means: TrackMemory[tuple[int, str], _Mean] = TrackMemory(_FORGET_SECONDS)

    def __call__(self, item: FrameFaces) -> FrameScene:
        return self.under(self._light(item), item)

    def under(self, lights: tuple[SceneLight, ...], item: FrameFaces) -> FrameScene:
        """Build the scene when the light on each face is known.  lights: in the faces' order."""
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
        return FrameScene(frame, coding, faces, item.cut)

    def _face(
        self, frame: Frame, coding: Coding, face: Face, light: SceneLight, seconds: float
    ) -> FaceScene:
        places = {name: region.places(face) for name, region in READ.items()}
        surfaces, sigma_px = self._surfaces(frame, coding, face, places)
        seen = SeenFace(frame, coding, face, surfaces)
        regions = {}
        for name, region in READ.items():
            lit = []
            for number, made in enumerate(region.surfaces(seen, places[name])):
                if made is not None:
                    surface, shading, mean = made
                    key = face.track_id, f"{name} {number}"
                    lit.append(Lit(surface, shading, self._smooth(key, mean, seconds)))
            regions[name] = tuple(lit)
        return FaceScene(face, light, regions, sigma_px)

    def _surfaces(
        self,
        frame: Frame,
        coding: Coding,
        face: Face,
        places: Mapping[str, list[GridPlace | None]],
    ) -> tuple[FaceSurfaces | None, Mapping[str, float]]:
        """The lips and lids of a face, from one call of the kernel, and how soft the picture is
        there. The surfaces are None where neither lips nor lids are seen."""
        grids = [place for name in READ for place in places[name]]
        there = [place for place in grids if place]
        if not there:
            return None, {}
        planes = light_planes(frame, coding, there, face.points_px[_LIT].tolist())
        surfaces = self._surface(grids, face.points_px, face.lips.logits, planes)
        return surfaces, softness_of(planes, face)

    def _smooth(self, key: tuple[int, str], mean: float, seconds: float) -> float:
        """The mean light of a region, smoothed over the frames' time."""
        before, last_seconds = self._means.get(key, _Mean(mean, seconds))
        since = seconds - last_seconds
        # `since` is 0 for a second face with the same id, which is not smoothed
        share = 1 - math.exp(-since / _SETTLE_SECONDS) if 0 < since < _FORGET_SECONDS else 1.0
        smooth = before + share * (mean - before)
        self._means[key] = _Mean(smooth, seconds)
        return smooth


def _surface(device: str) -> SurfaceKernel:
    return SurfaceKernel(open_device(device), np.concatenate([LIP_RINGS, LID_RINGS]))


# One kernel for all threads of a process: each single picture makes its own BuildScene.
_shared_surface = once_a_process(_surface)
