"""inspect_video: finds the faces in a video or a picture and draws them onto it."""

import contextlib
import os

from makeup_video.pipeline.engine.machine import one_opencv_thread
from makeup_video.pipeline.errors import UsageError, option
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.files.path_argument import check_path
from makeup_video.pipeline.offline.overlay import DrawFaces
from makeup_video.pipeline.offline.points_file import PointsFile
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.run import run_stages
from makeup_video.pipeline.offline.settings import Settings, check_progress
from makeup_video.pipeline.offline.stages import FaceRun
from makeup_video.pipeline.offline.video import Progress


def inspect_video(
    src: str | os.PathLike[str],
    dst: str | os.PathLike[str],
    points: str | os.PathLike[str] | None = None,
    settings: Settings | None = None,
    on_progress: Progress | None = None,
) -> Report:
    """Draw points, lip mask, number and scores of every face in src, and write dst.

    points: a file for the points as JSON, one frame per line. After Ctrl-C the points so far stay
    under the name of the part, beside the part of dst.
    settings: as in process_video, but without `split_minutes` and `faces`.
    Raises TypeError for an argument of a wrong type, else one of `errors`.
    """
    check_path("src", src)
    check_path("dst", dst)
    if points is not None:
        check_path("points", points)
    settings = Settings.checked(settings)
    check_progress(on_progress)
    for name in settings.given(("split_minutes", "faces")):
        raise UsageError(f"all faces are drawn, in one run: leave out {option(name)}")
    local_file(src, "video or photo")  # these words keep a folder's error from advising a batch
    sidecar: contextlib.AbstractContextManager[PointsFile | None] = contextlib.nullcontext()
    if points is not None:
        sidecar = PointsFile(points, src, dst, overwrite=settings.overwrite)
    with sidecar as points_file, one_opencv_thread():
        run = FaceRun(lambda: [("draw", DrawFaces(points_file))], paints=False)
        report = run_stages(src, dst, run, settings, on_progress)
    run.count(report)
    return report
