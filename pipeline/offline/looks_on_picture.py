"""Paints several looks on one picture, which is decoded and searched for faces only once."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.engine.split_evenly import split_evenly
from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.media.for_each_output import CopyFrames
from makeup_video.pipeline.offline.picture import (
    OpenedPicture,
    check_suffix,
    open_picture,
    write_picture,
)
from makeup_video.pipeline.offline.report import Outcome
from makeup_video.pipeline.offline.settings import Settings
from makeup_video.pipeline.offline.stages import FaceRun, count_painted
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite, open_canvas
from makeup_video.pipeline.render.scene import FrameScene


def paint_picture(src: Path, looks: Mapping[Path, Look], settings: Settings) -> dict[Path, Outcome]:
    """Paint every look on the picture, as many looks at once as there are cores.

    looks: by output, one or more; see process_looks.
    """
    for output in looks:
        check_suffix(src, output)
    picture = open_picture(src)
    faces = FaceRun(lambda: [("scene", BuildScene(settings.device))], paints=True)
    scene: Any = picture.frame
    for _, stage in faces(None):
        scene = stage(scene)
    work = _Work(picture, scene, faces, settings)
    outputs = list(looks.items())
    spans = split_evenly(len(outputs), cores())
    groups = [dict(outputs[span.start : span.stop]) for span in spans]
    done: dict[Path, Outcome] = {}
    with ThreadPoolExecutor(len(groups)) as pool:
        try:
            for part in pool.map(work, groups):
                done |= part
        except BaseException:
            work.is_stopped = True  # else the pool would wait until all looks are painted
            raise
    return done


class _Work:
    """What one thread does: paints some of the looks on copies of the scene's frame."""

    def __init__(
        self, picture: OpenedPicture, scene: FrameScene, faces: FaceRun, settings: Settings
    ) -> None:
        self._picture, self._scene, self._faces = picture, scene, faces
        self._settings = settings
        self.is_stopped = False

    def __call__(self, looks: Mapping[Path, Look]) -> dict[Path, Outcome]:
        canvas, copy = open_canvas(self._settings.device), CopyFrames(1)
        done: dict[Path, Outcome] = {}
        for output, look in looks.items():
            if self.is_stopped:
                break
            (frame,) = copy(self._scene.frame)
            composite = None
            if not look.is_bare:
                composite = Composite(look, canvas, self._settings.faces)
                composite(replace(self._scene, frame=frame))
            try:
                report = write_picture(self._picture, output, frame, self._settings)
            except MakeupVideoError as error:
                done[output] = error
                continue
            if composite is not None:
                self._faces.count(report)
                count_painted(composite, report)
            done[output] = report
        return done
