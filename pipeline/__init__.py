"""makeup-video as a library.

from makeup_video.pipeline import Look, apply_look, find_faces, lip_mask, process_video
from makeup_video.pipeline import product, ready_look
look = Look(lips=product("#B4002E", "gloss"))  # or Look.load("look.json")
look = ready_look("cat-eye").look
report = process_video("in.mp4", "out.mp4", look)
done = process_looks("in.mp4", {"a.mp4": look, "b.mp4": other})  # read once
painted = apply_look(rgb8, look)  # one picture
for painted in paint_frames(frames, look): ...  # the frames of a video, tracked and smoothed
look = estimate_look(rgb8)  # or look_from_photo("look.jpg"): the makeup in a photo
faces = find_faces(rgb8)  # largest first
weight = lip_mask(rgb8, faces[0])
"""

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

# ONNX Runtime's own builds report to Microsoft which nets are loaded and how they run, unless this
# is set before the library is first imported. Nothing of ours is sent anywhere, whatever was set.
os.environ["ORT_DISABLE_TELEMETRY"] = "1"

from makeup_video.pipeline.errors import (
    CatalogueError,
    DecodeError,
    EncodeError,
    InputError,
    InstallError,
    LookError,
    MakeupVideoError,
    OutputError,
    PhotoError,
    SeveralFacesError,
    StoppedError,
    StrictError,
    TooLittleMemoryError,
    UsageError,
    WorkerError,
)

__all__ = [
    "FINISHES",
    "KINDS",
    "CatalogueError",
    "ColourTags",
    "DecodeError",
    "EncodeError",
    "Estimate",
    "Face",
    "FindFaces",
    "Frame",
    "FrameFaces",
    "GraphicsParams",
    "InputError",
    "InstallError",
    "Layer",
    "LipPatch",
    "Look",
    "LookError",
    "MakeupVideoError",
    "OutputError",
    "Painter",
    "PhotoError",
    "ReadyLook",
    "Report",
    "Settings",
    "SeveralFacesError",
    "StoppedError",
    "StrictError",
    "TooLittleMemoryError",
    "UsageError",
    "WorkerError",
    "apply_look",
    "estimate_look",
    "estimate_photo",
    "find_faces",
    "inspect_video",
    "lip_mask",
    "look_from_photo",
    "paint_frames",
    "paint_pictures",
    "process_looks",
    "process_video",
    "product",
    "ready_look",
    "ready_looks",
]

if TYPE_CHECKING:
    from makeup_video.pipeline.faces.face import Face, FrameFaces, LipPatch
    from makeup_video.pipeline.faces.find import find_faces
    from makeup_video.pipeline.faces.lip_mask import lip_mask
    from makeup_video.pipeline.faces.tracker import FindFaces
    from makeup_video.pipeline.frames.colour_tags import ColourTags
    from makeup_video.pipeline.frames.frame import Frame
    from makeup_video.pipeline.look.finishes import FINISHES, product
    from makeup_video.pipeline.look.kinds import KINDS
    from makeup_video.pipeline.look.look import Layer, Look
    from makeup_video.pipeline.look.params import GraphicsParams
    from makeup_video.pipeline.look.ready import ReadyLook, ready_look, ready_looks
    from makeup_video.pipeline.offline.inspect_faces import inspect_video
    from makeup_video.pipeline.offline.looks import process_looks
    from makeup_video.pipeline.offline.painter import Painter, paint_frames, paint_pictures
    from makeup_video.pipeline.offline.process import process_video
    from makeup_video.pipeline.offline.report import Report
    from makeup_video.pipeline.offline.settings import Settings
    from makeup_video.pipeline.reference.estimate import (
        Estimate,
        estimate_look,
        estimate_photo,
        look_from_photo,
    )
    from makeup_video.pipeline.render.apply_look import apply_look

# FFmpeg, ONNX Runtime, OpenCV and OpenCL are slow to import, so each name is imported when used.
_LATER = {
    "Face": "faces.face",
    "FrameFaces": "faces.face",
    "LipPatch": "faces.face",
    "ColourTags": "frames.colour_tags",
    "Frame": "frames.frame",
    "FINISHES": "look.finishes",
    "product": "look.finishes",
    "KINDS": "look.kinds",
    "Layer": "look.look",
    "Look": "look.look",
    "GraphicsParams": "look.params",
    "ReadyLook": "look.ready",
    "ready_look": "look.ready",
    "ready_looks": "look.ready",
    "process_looks": "offline.looks",
    "process_video": "offline.process",
    "Report": "offline.report",
    "Settings": "offline.settings",
}
_LATER_WITH_NETS = {
    "FindFaces": "faces.tracker",
    "find_faces": "faces.find",
    "lip_mask": "faces.lip_mask",
    "inspect_video": "offline.inspect_faces",
    "Painter": "offline.painter",
    "paint_frames": "offline.painter",
    "paint_pictures": "offline.painter",
    "apply_look": "render.apply_look",
    "Estimate": "reference.estimate",
    "estimate_look": "reference.estimate",
    "estimate_photo": "reference.estimate",
    "look_from_photo": "reference.estimate",
}

if not TYPE_CHECKING:  # type checkers would take any name for one of the module's

    def __getattr__(name: str) -> Any:
        module = {**_LATER, **_LATER_WITH_NETS}.get(name)
        if module is None:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from makeup_video.pipeline.engine.machine import FIND_FACES, LOAD, check_memory

        # with less memory, loading their libraries would end the process without a message
        check_memory(FIND_FACES if name in _LATER_WITH_NETS else LOAD)
        # kept as a global, so that nothing is checked when the name is used again
        globals()[name] = getattr(import_module(f"{__name__}.{module}"), name)
        return globals()[name]


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
