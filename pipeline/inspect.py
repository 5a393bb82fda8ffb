"""Show on a picture or a video what was found of faces: for people who wonder why."""

import os
from collections.abc import Callable
from pathlib import Path

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

    points: also write the points as JSON there, one frame a line. Raises one of `errors`.
    """
    points_file = None if points is None else PointsFile(Path(points))
    draw = DrawFaces(points_file)
    finders: list[FindFaces] = []

    def stages(source: VideoSource) -> list[tuple[str, Stage]]:
        finders.append(FindFaces(source.video.sample_aspect_ratio or 1))
        return [("faces", finders[0]), ("smooth", SmoothAhead()), ("draw", draw)]

    found = _Still(draw)
    try:
        report = run_stages(src, dst, stages, found, settings, on_progress)
    finally:
        if points_file is not None:
            points_file.close()
    for finder in finders:
        report.frames_with_face, report.faces = finder.frames_with_face, finder.faces
        report.tiny_faces = finder.tiny_faces
    if report.is_picture:
        report.frames_with_face, report.faces = int(found.faces > 0), found.faces
    return report


class _Still:
    """The one frame of a picture, with what was found drawn on it."""

    def __init__(self, draw: Callable[..., Frame]) -> None:
        self.draw, self.faces = draw, 0

    def __call__(self, frame: Frame) -> Frame:
        item = find_faces_in_frame(frame)
        self.faces = len(item.faces)
        return self.draw(item)
