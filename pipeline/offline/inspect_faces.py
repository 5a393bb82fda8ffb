"""Show on a picture or a video what was found of faces: for people who wonder why."""

import contextlib
import os

from makeup_video.pipeline.engine.machine import one_opencv_thread
from makeup_video.pipeline.offline.overlay import DrawFaces
from makeup_video.pipeline.offline.points_file import PointsFile
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.run import Progress, run_stages
from makeup_video.pipeline.offline.settings import Settings
from makeup_video.pipeline.offline.stages import FaceRun


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
    with side as points_file, one_opencv_thread():
        run = FaceRun(lambda: [("draw", DrawFaces(points_file))])
        report = run_stages(src, dst, run, settings, on_progress)
    run.count(report)
    return report
