"""Show on a picture or a video what was found of faces: for people who wonder why."""

import contextlib
import os
from collections.abc import Callable

from makeup_video.pipeline.faces import FindFaces, find_faces_in_frame
from makeup_video.pipeline.frame import Frame
from makeup_video.pipeline.overlay import DrawFaces, PointsFile
from makeup_video.pipeline.process import Progress, Settings, run_stages
from makeup_video.pipeline.report import Report
from makeup_video.pipeline.runner import Stage
from makeup_video.pipeline.smooth import SmoothAhead
from makeup_video.pipeline.source import VideoSource


def inspect_video(
    src: str | os.PathLike[str],
    dst: str | os.PathLike[str],
    points: str | os.PathLike[str] | None = None,
    settings: Settings | None = None,
    on_progress: Progress | None = None,
) -> Report:
    """Draw points, lip mask, number and scores of every face of src, and write dst.

    points: also write the points as JSON there, one frame a line. After Ctrl-C what was found so
    far stays under its part name, beside the part of dst. Raises one of `errors`.
    """
    settings = settings or Settings()
    side: contextlib.AbstractContextManager[PointsFile | None] = contextlib.nullcontext()
    if points is not None:
        side = PointsFile(points, src, dst, overwrite=settings.overwrite)
    finders: list[FindFaces] = []
    with side as points_file:
        draw = DrawFaces(points_file)

        def stages(source: VideoSource) -> list[tuple[str, Stage]]:
            finders.append(FindFaces(source.video.sample_aspect_ratio or 1))
            return [("faces", finders[0]), ("smooth", SmoothAhead()), ("draw", draw)]

        still = _Still(draw)
        report = run_stages(src, dst, stages, still, settings, on_progress)
    found = still if report.is_picture else finders[0]
    report.frames_with_face, report.faces = found.frames_with_face, found.faces
    report.tiny_faces = found.tiny_faces
    return report


class _Still:
    """The one frame of a picture, with what was found drawn on it; counts as FindFaces does."""

    def __init__(self, draw: Callable[..., Frame]) -> None:
        self.draw = draw
        self.frames_with_face = self.faces = self.tiny_faces = 0

    def __call__(self, frame: Frame) -> Frame:
        item, self.tiny_faces = find_faces_in_frame(frame)
        self.faces, self.frames_with_face = len(item.faces), int(bool(item.faces))
        return self.draw(item)
