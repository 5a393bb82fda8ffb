"""The stages of every run that looks for faces, and what such a run counts."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import cv2
from makeup_video.pipeline.face import FrameFaces
from makeup_video.pipeline.faces import FindFaces, find_faces_in_frame
from makeup_video.pipeline.frame import Frame
from makeup_video.pipeline.memory import FIND_FACES, SHOW_VIDEO, Need, check_memory
from makeup_video.pipeline.report import Report
from makeup_video.pipeline.runner import Stage
from makeup_video.pipeline.smooth import SmoothAhead
from makeup_video.pipeline.source import VideoSource

Stages = list[tuple[str, Stage]]


@contextmanager
def one_opencv_thread() -> Iterator[None]:
    """OpenCV works on the thread that calls it, until the block ends.

    Pictures of lips and eyes are too small to share: waking OpenCV's own threads for them costs
    0.7 ms of CPU time a frame and makes no run shorter.
    """
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)


class FaceRun:
    """Finds faces, steadies them in a video, and goes on with `rest` (FrameFaces -> Frame).

    rest() makes these stages, once the input is known to be there and before the output is begun.
    video, picture: the memory of the whole run for one.
    """

    def __init__(
        self, rest: Callable[[], Stages], video: Need = SHOW_VIDEO, picture: Need = FIND_FACES
    ) -> None:
        self._rest, self._video, self._picture = rest, video, picture
        self._found: FindFaces | _FindOnce

    def __call__(self, source: VideoSource | None) -> Stages:
        """For a video, or for a picture (None). Raises TooLittleMemoryError."""
        if source is None:
            check_memory(self._picture)
        else:
            check_memory(self._video, source.frame_px)
        rest = self._rest()
        if source is None:
            self._found = _FindOnce()
            return [("faces", self._found), *rest]
        self._found = FindFaces(source.video.sample_aspect_ratio or 1)
        return [("faces", self._found), ("smooth", SmoothAhead()), *rest]

    def count(self, report: Report) -> None:
        """Put into the report what was found."""
        report.frames_with_face = self._found.frames_with_face
        report.faces, report.tiny_faces = self._found.faces, self._found.tiny_faces


class _FindOnce:
    """Frame -> FrameFaces for the one frame of a picture; counts as FindFaces does."""

    def __init__(self) -> None:
        self.frames_with_face = self.faces = self.tiny_faces = 0

    def __call__(self, frame: Frame) -> FrameFaces:
        item, self.tiny_faces = find_faces_in_frame(frame)
        self.faces, self.frames_with_face = len(item.faces), int(bool(item.faces))
        return item
