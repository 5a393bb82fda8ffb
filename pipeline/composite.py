"""STAND-IN, not to be merged: lightens the box of the lips, darkens those of the eyes."""

import numpy as np
from makeup_video.pipeline.device import open_device
from makeup_video.pipeline.frame import Frame
from makeup_video.pipeline.look import Look
from makeup_video.pipeline.scene import FaceScene, FrameScene
from makeup_video.pipeline.topology import EYE, LIPS, RIGHT_EYE


class Composite:
    """FrameScene -> Frame."""

    def __init__(self, look: Look, device: str = "", faces: str = "all") -> None:
        open_device(device)
        self.faces, self.painted_frames = faces, 0
        self.set_look(look)

    def set_look(self, look: Look) -> None:
        self.look = look

    def __call__(self, item: FrameScene) -> Frame:
        if chosen := self._chosen(item.faces):
            luma = item.frame.writable_planes()[0]
            for scene in chosen:
                if self.look.lips:
                    _add(luma, scene.face.points_px[LIPS, :2], 20 << item.frame.bit_depth - 8)
                if self.look.eyes:
                    for eye in (EYE, RIGHT_EYE):
                        box = scene.face.points_px[eye, :2]
                        _add(luma, box, -(20 << item.frame.bit_depth - 8))
            self.painted_frames += 1
        return item.frame

    def _chosen(self, faces: tuple[FaceScene, ...]) -> tuple[FaceScene, ...]:
        if self.faces in ("all", "largest"):
            return faces[:1] if self.faces == "largest" else faces
        return tuple(scene for scene in faces if scene.face.track_id == int(self.faces))


def _add(luma: np.ndarray, xy: np.ndarray, value: int) -> None:
    (x0, y0), (x1, y1) = xy.min(0).clip(0).astype(int), xy.max(0).clip(0).astype(int)
    part = luma[y0:y1, x0:x1]
    top = 255 if luma.dtype == np.uint8 else 1023
    part[:] = (part.astype(np.int32) + value).clip(0, top)
