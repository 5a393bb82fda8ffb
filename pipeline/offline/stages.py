"""The stages of the runs that find faces, and what these runs count."""

from collections.abc import Callable

from makeup_video.pipeline.engine.machine import (
    FIND_FACES,
    PAINT_PICTURE,
    PAINT_VIDEO,
    SHOW_VIDEO,
    check_memory,
)
from makeup_video.pipeline.engine.runner import Stage
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.faces.find import find_faces_in_frame
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.unpainted import tell_unpainted
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead

Stages = list[tuple[str, Stage]]


class FaceRun:
    """Finds faces, smooths them over time in a video, and goes on with the stages of `rest`.

    rest() makes these stages (FrameFaces -> Frame). It is called once the input is open and before
    the output is begun.
    paints: whether the whole run paints, which needs more memory than finding faces alone.
    """

    def __init__(self, rest: Callable[[], Stages], *, paints: bool) -> None:
        self._rest: Callable[[], Stages] | None = rest
        self._paints = paints
        self._found: FindFaces | _FindOnce

    def __call__(self, source: VideoSource | None) -> Stages:
        """The stages for a video, or for a picture (None). Raises TooLittleMemoryError."""
        if source is None:
            check_memory(PAINT_PICTURE if self._paints else FIND_FACES)
        else:
            check_memory(PAINT_VIDEO if self._paints else SHOW_VIDEO, source.frame_px)
        assert self._rest is not None, "a run has its stages made once"
        # `rest` may refer to the owner of this run, and would keep encoders and decoders in memory
        make_rest, self._rest = self._rest, None
        rest = make_rest()
        if source is None:
            self._found = _FindOnce()
            return [("faces", self._found), *rest]
        self._found = FindFaces(source.video.sample_aspect_ratio or 1)
        return [("faces", self._found), ("smooth", SmoothAhead()), *rest]

    def count(self, report: Report) -> None:
        """Write the counts of faces into the report."""
        report.frames_with_face = self._found.frames_with_face
        report.faces, report.tiny_faces = self._found.faces, self._found.tiny_faces


class _FindOnce:
    """Finds the faces in the one frame of a picture, and counts them as FindFaces does."""

    def __init__(self) -> None:
        self.frames_with_face = self.faces = self.tiny_faces = 0

    def __call__(self, frame: Frame) -> FrameFaces:
        item, self.tiny_faces = find_faces_in_frame(frame)
        self.faces, self.frames_with_face = len(item.faces), int(bool(item.faces))
        return item


class PaintRun(FaceRun):
    """Finds faces and paints a look on them; `faces` and `device` as in Settings.

    composite: the stage that paints, once the stages are made.
    """

    composite: Composite

    def __init__(self, look: Look, faces: str = "all", device: str = "") -> None:
        super().__init__(self._painting, paints=True)
        self._look, self._faces, self._device = look, faces, device

    def _painting(self) -> Stages:
        self.composite = Composite(self._look, self._device, self._faces)
        return [("scene", BuildScene(self._device)), ("composite", self.composite)]

    def count(self, report: Report) -> None:
        super().count(report)
        count_painted(self.composite, report)


def count_painted(composite: Composite, report: Report) -> None:
    """Write how many frames were painted into a report that already has its counts of faces."""
    report.painted_frames = composite.painted_frames
    tell_unpainted(
        report,
        composite.look,
        composite.faces,
        composite.chosen_frames,
        composite.numbers,
        composite.painted_areas,
    )
