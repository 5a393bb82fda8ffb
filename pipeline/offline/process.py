"""process_video: paints a look on a video or a picture."""

import os
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from makeup_video.pipeline.engine.jobs import Worker
from makeup_video.pipeline.engine.machine import (
    COPY_VIDEO,
    FIND_FACES,
    check_memory,
    give_back_last_run,
    one_opencv_thread,
)
from makeup_video.pipeline.engine.runner import Stage
from makeup_video.pipeline.errors import DecodeError
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.files.path_argument import check_path
from makeup_video.pipeline.images.picture_file import is_picture
from makeup_video.pipeline.look.look import Look, check_look
from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.run import check_name, run_stages
from makeup_video.pipeline.offline.settings import Settings, check_progress, check_workers
from makeup_video.pipeline.offline.video import Progress


def process_video(
    src: str | os.PathLike[str],
    dst: str | os.PathLike[str],
    look: Look | None = None,
    settings: Settings | None = None,
    on_progress: Progress | None = None,
    workers: Sequence[Worker] | None = None,
) -> Report:
    """Paint `look` (None: nothing) on every frame of src, a video or a picture, and write dst.

    on_progress(frames done, frames expected or None, frames per second of the source) is called a
    few times a second.
    workers: paint the segments of `split_minutes`; None: processes of this machine. Workers are
    stopped when the segments end, and serve no other video. A video that is painted whole does not
    use them.
    Raises TypeError for an argument of a wrong type, else one of `errors`; dst is then unchanged,
    or still does not exist.
    A script that sets `split_minutes` needs `if __name__ == "__main__"` around its call, since the
    processes of the segments import it.
    """
    check_path("src", src)
    check_path("dst", dst)
    look, settings = Look() if look is None else look, Settings.checked(settings)
    check_look(look)
    check_progress(on_progress)
    check_workers(workers)
    if settings.split_minutes is not None and not is_picture(local_file(src)):
        return _in_segments(src, dst, look, settings, settings.split_minutes, on_progress, workers)
    if look.is_bare:
        return run_stages(src, dst, _copy, settings, on_progress)
    check_memory(FIND_FACES)
    # late: the face nets and OpenCL take long to load, and only painting needs them
    from makeup_video.pipeline.offline.stages import PaintRun

    run = PaintRun(look, settings.faces, settings.device)
    try:
        with one_opencv_thread():
            report = run_stages(src, dst, run, settings, on_progress)
        run.count(report)
    finally:
        del run
        give_back_last_run()
    return report


def _in_segments(
    src: str | os.PathLike[str],
    dst: str | os.PathLike[str],
    look: Look,
    settings: Settings,
    minutes: Fraction,
    on_progress: Progress | None,
    workers: Sequence[Worker] | None,
) -> Report:
    """Paint the video in segments, or in one run where it cannot be split."""
    from makeup_video.pipeline.offline.split import plan_of, process_in_segments

    check_name(dst)
    plan = plan_of(src, look, minutes, settings)
    obstacle = plan.obstacle
    if len(plan.segments) > 1:
        try:
            return process_in_segments(src, dst, plan, look, settings, on_progress, workers)
        except DecodeError as error:
            if not error.shows_nothing:
                raise
            obstacle = "a segment of it is damaged"  # other frames of the video may be whole
    whole = replace(settings, split_minutes=None, jobs=None)
    report = process_video(src, dst, look, whole, on_progress)
    report.why_whole = obstacle
    return report


def _copy(source: VideoSource | None) -> list[tuple[str, Stage]]:
    """The stages of a run that paints nothing: none between decoder and encoder."""
    if source is not None:
        check_memory(COPY_VIDEO, source.frame_px)
    return []
