"""FrameFaces -> FrameScene: each face's lips and lids as surfaces, and the light on them."""

import math

from makeup_video.kernels.colour import Coding
from makeup_video.pipeline.colour import coding_of
from makeup_video.pipeline.eyes import eye_regions
from makeup_video.pipeline.face import Face, FrameFaces
from makeup_video.pipeline.frame import Frame
from makeup_video.pipeline.light import EstimateLight
from makeup_video.pipeline.lips import lip_region
from makeup_video.pipeline.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.shading import luminances

# A region's mean light follows as slowly as the light on the face does: so a shadow that passes
# is seen on the product at once, as on the skin.
_SETTLE_SECONDS = 0.5
_FORGET_SECONDS = 1.0


class BuildScene:
    """Keeps, for each track, the light of its regions."""

    def __init__(self) -> None:
        self._light = EstimateLight()
        self._means: dict[tuple[int, str], tuple[float, float]] = {}

    def __call__(self, item: FrameFaces) -> FrameScene:
        return self.under(self._light(item), item)

    def under(self, lights: tuple[SceneLight, ...], item: FrameFaces) -> FrameScene:
        """The same when the light on each face is known."""
        frame = item.frame
        coding = coding_of(frame)
        if item.cut:
            self._means.clear()
        seconds = float(frame.pts * frame.time_base)
        faces = tuple(
            self._face(frame, coding, face, light, seconds)
            for face, light in zip(item.faces, lights, strict=True)
        )
        self._means = {
            key: value
            for key, value in self._means.items()
            if abs(seconds - value[1]) < _FORGET_SECONDS
        }
        return FrameScene(frame, coding, faces)

    def _face(
        self, frame: Frame, coding: Coding, face: Face, light: SceneLight, seconds: float
    ) -> FaceScene:
        mouth, lids = lip_region(face), eye_regions(face)
        grids = [*([mouth.grid] if mouth else []), *(lid.grid for lid in lids)]
        luminance = iter(luminances(frame, coding, grids) if grids else [])
        lit_mouth = None
        if mouth:
            shading, mean = mouth.shaded(next(luminance))
            lit_mouth = Lit(mouth, shading, self._smooth((face.track_id, "lips"), mean, seconds))
        lit_lids = []
        for number, lid in enumerate(lids):
            shading, mean = lid.shaded(next(luminance))
            key = face.track_id, f"eye {number}"
            lit_lids.append(Lit(lid, shading, self._smooth(key, mean, seconds)))
        return FaceScene(face, light, lit_mouth, tuple(lit_lids))

    def _smooth(self, key: tuple[int, str], mean: float, seconds: float) -> float:
        """The mean light of a region, smoothed by the frames' time."""
        before, at = self._means.get(key, (mean, seconds))
        since = seconds - at
        # no time since: a second face of one number
        share = 1 - math.exp(-since / _SETTLE_SECONDS) if 0 < since < _FORGET_SECONDS else 1.0
        smooth = before + share * (mean - before)
        self._means[key] = smooth, seconds
        return smooth
