"""Writes each kind of output file of the product in the shortest way."""

import cv2
import numpy as np
from makeup_video.pipeline import Settings
from makeup_video.pipeline.files.sidecar import ReportFile
from makeup_video.pipeline.live.interfaces import LivePicture
from makeup_video.pipeline.live.sinks.recording import Recording
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera
from makeup_video.pipeline.offline.run import run_stages
from media import make_clip, picture


def make_video(folder, name, during=lambda: None, *, overwrite=False):
    """Like the other writers, calls `during` while the file is being written."""
    run(make_clip(folder / "in.mp4"), folder / name, during, overwrite)


def make_picture(folder, name, during=lambda: None, *, overwrite=False):
    src = folder / "in.png"
    cv2.imwrite(str(src), np.arange(40 * 60 * 3).astype(np.uint8).reshape(40, 60, 3))
    run(src, folder / name, during, overwrite)


def run(src, dst, during, overwrite=False):
    """Copy a video or a picture; returns the report."""

    def stage(frame):
        during()
        return frame

    return run_stages(src, dst, lambda _: [("during", stage)], Settings(overwrite=overwrite), None)


def make_recording(folder, name, during=lambda: None, *, overwrite=False):
    recording, door = Recording(folder / name, overwrite=overwrite), NormaliseCamera(is_device=True)
    for index in range(3):
        recording(LivePicture(door(picture(index, 96, 64), 5.0 + index / 25)))
    during()
    recording.finish()


def make_report(folder, name, during=lambda: None, *, overwrite=False):
    src = make_clip(folder / "in.mp4", frames=1)
    with ReportFile(folder / name, src, None, overwrite=overwrite) as file:
        file.write({"frames": 1})
        during()


WRITERS = [
    (make_video, "out.mp4"),
    (make_video, "out.mkv"),
    (make_picture, "out.png"),
    (make_recording, "out.mp4"),
    (make_recording, "out.mkv"),
    (make_report, "out.json"),
]
