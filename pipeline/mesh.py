"""STAND-IN, not to be merged: FrameFaces -> FrameScene with white light everywhere."""

from makeup_video.pipeline.face import FrameFaces
from makeup_video.pipeline.scene import FaceScene, FrameScene, white_light


class BuildScene:
    """FrameFaces -> FrameScene."""

    def __init__(self) -> None:
        self._light = white_light()

    def __call__(self, item: FrameFaces) -> FrameScene:
        return FrameScene(item.frame, tuple(FaceScene(face, self._light) for face in item.faces))
