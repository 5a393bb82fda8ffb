"""makeup-video as a library.

from makeup_video.pipeline import Look, apply_look, find_faces, lip_mask, process_video, product
look = Look(lips=product((180, 0, 46), "gloss"))  # or Look.load("look.json")
report = process_video("in.mp4", "out.mp4", look)
painted = apply_look(rgb8, look)  # one picture
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
    StoppedError,
    StrictError,
    TooLittleMemoryError,
    UsageError,
)

__all__ = [
    "FINISHES",
    "CatalogueError",
    "ColourTags",
    "DecodeError",
    "EncodeError",
    "Face",
    "FindFaces",
    "Frame",
    "FrameFaces",
    "GraphicsParams",
    "InputError",
    "InstallError",
    "LipPatch",
    "Look",
    "LookError",
    "MakeupVideoError",
    "OutputError",
    "PhotoError",
    "Report",
    "Settings",
    "StoppedError",
    "StrictError",
    "TooLittleMemoryError",
    "UsageError",
    "apply_look",
    "estimate_look",
    "find_faces",
    "inspect_video",
    "lip_mask",
    "look_from_photo",
    "process_video",
    "product",
]

if TYPE_CHECKING:
    from makeup_video.pipeline.face import Face, FrameFaces, LipPatch
    from makeup_video.pipeline.faces import FindFaces, find_faces, lip_mask
    from makeup_video.pipeline.finishes import FINISHES, product
    from makeup_video.pipeline.frame import ColourTags, Frame
    from makeup_video.pipeline.inspect import inspect_video
    from makeup_video.pipeline.look import GraphicsParams, Look
    from makeup_video.pipeline.paint import apply_look
    from makeup_video.pipeline.process import Settings, process_video
    from makeup_video.pipeline.reference import estimate_look, look_from_photo
    from makeup_video.pipeline.report import Report

# FFmpeg, ONNX Runtime, OpenCV and OpenCL are slow to import: only those who need them wait.
_LATER = {
    "Face": "face",
    "FrameFaces": "face",
    "LipPatch": "face",
    "FINISHES": "finishes",
    "product": "finishes",
    "ColourTags": "frame",
    "Frame": "frame",
    "GraphicsParams": "look",
    "Look": "look",
    "Settings": "process",
    "process_video": "process",
    "Report": "report",
}
_LATER_WITH_NETS = {
    "FindFaces": "faces",
    "find_faces": "faces",
    "lip_mask": "faces",
    "inspect_video": "inspect",
    "apply_look": "paint",
    "estimate_look": "reference",
    "look_from_photo": "reference",
}


def __getattr__(name: str) -> Any:
    module = {**_LATER, **_LATER_WITH_NETS}.get(name)
    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from makeup_video.pipeline.memory import FIND_FACES, LOAD, check_memory

    # with less, their libraries end the process while they are loaded, and say nothing
    check_memory(FIND_FACES if name in _LATER_WITH_NETS else LOAD)
    return getattr(import_module(f"{__name__}.{module}"), name)
