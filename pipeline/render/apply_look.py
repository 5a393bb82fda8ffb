"""Paints looks: the run of a video or a picture, and one picture in memory."""

from collections.abc import Iterable

import numpy as np
from makeup_video.pipeline.composite import Composite
from makeup_video.pipeline.crop import check_rgb8
from makeup_video.pipeline.face import Face, FrameFaces
from makeup_video.pipeline.face_run import FaceRun, Stages
from makeup_video.pipeline.face_tracks import sound_faces
from makeup_video.pipeline.faces import find_faces_in_frame
from makeup_video.pipeline.look import Look
from makeup_video.pipeline.memory import PAINT_PICTURE, PAINT_VIDEO
from makeup_video.pipeline.mesh import BuildScene
from makeup_video.pipeline.report import Report
from makeup_video.pipeline.still import merge, to_frame

_MOST_NUMBERS = 10


class PaintRun(FaceRun):
    """Finds faces and paints a look on them; `faces` and `device` as in Settings."""

    def __init__(self, look: Look, faces: str = "all", device: str = "") -> None:
        super().__init__(self._painting, PAINT_VIDEO, PAINT_PICTURE)
        self._look, self._faces, self._device = look, faces, device

    def _painting(self) -> Stages:
        self._composite = Composite(self._look, self._device, self._faces)
        return [("scene", BuildScene(self._device)), ("composite", self._composite)]

    def count(self, report: Report) -> None:
        super().count(report)
        report.painted_frames = self._composite.painted_frames
        if not report.painted_frames and report.frames_with_face:
            report.why_unpainted = self._why_unpainted(report.turn_first)

    def _why_unpainted(self, turn_first: str) -> str:
        """Why no face that was found is painted."""
        composite, whom = self._composite, self._faces
        if not composite.chosen_frames and whom.isdigit():
            return f"--faces {whom}, but {_numbered(sorted(composite.numbers))}"
        hidden = [
            part
            for part, params in (("mouth", self._look.lips), ("eyes", self._look.eyes))
            if params is not None and params.is_worn
        ]
        if not hidden:
            return "the look neither covers, nor shines, nor mirrors"
        return f"no {' or '.join(hidden)} could be seen in the faces found; {turn_first}"


def _numbered(numbers: list[int]) -> str:
    """Which faces there were, at most ten of them by number."""
    texts = [str(number) for number in numbers]
    if len(texts) > _MOST_NUMBERS:
        texts[_MOST_NUMBERS:] = [f"{len(texts) - _MOST_NUMBERS} more"]
    if len(texts) < 2:
        return f"the only face seen was {''.join(texts)}" if texts else "no face was seen for long"
    return f"the faces seen were {', '.join(texts[:-1])} and {texts[-1]}"


def apply_look(rgb8: np.ndarray, look: Look, faces: Iterable[Face] | None = None) -> np.ndarray:
    """A picture with the look painted on its faces; pixels that nobody paints keep their values.

    rgb8: (H, W, 3) uint8, upright, R'G'B' as sRGB encodes it, any size; it is not changed.
    faces: those to paint, as `find_faces` found them in this very picture; None: all there are;
    those with numbers that are not finite are left alone.
    Returns a new (H, W, 3) uint8 array, encoded alike; a plain copy when there is no face or the
    look is bare.  Raises ValueError for another shape or dtype, InstallError when the face nets
    or OpenCL are missing.
    """
    check_rgb8(rgb8)
    if look.is_bare:
        return rgb8.copy()
    stored = np.ascontiguousarray(rgb8[..., ::-1])
    frame = to_frame(stored)
    before = [plane.copy() for plane in frame.planes]
    item = find_faces_in_frame(frame)[0] if faces is None else FrameFaces(frame, tuple(faces))
    sound = FrameFaces(frame, sound_faces(item))
    painted = Composite(look)(BuildScene()(sound))
    return np.ascontiguousarray(merge(stored, painted, before)[..., ::-1])
