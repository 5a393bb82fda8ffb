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
    UsageError,
)
from makeup_video.pipeline.face import Face, FrameFaces, LipPatch
from makeup_video.pipeline.finishes import FINISHES, product
from makeup_video.pipeline.frame import ColourTags, Frame
from makeup_video.pipeline.look import GraphicsParams, Look
from makeup_video.pipeline.memory import FIND_FACES, check_memory
from makeup_video.pipeline.process import Settings, process_video
from makeup_video.pipeline.report import Report

# Before ONNX Runtime is imported: since 1.29 it reports to Microsoft what it runs unless told not to, and keeps a
# database for it in the user's cache folder. Nothing that we do leaves the machine.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")

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
    from makeup_video.pipeline.faces import FindFaces, find_faces, lip_mask
    from makeup_video.pipeline.inspect import inspect_video
    from makeup_video.pipeline.paint import apply_look
    from makeup_video.pipeline.reference import estimate_look, look_from_photo

# ONNX Runtime, OpenCV and OpenCL take their time to import: only for those who look for faces.
_LATER = {
    "FindFaces": "faces",
    "find_faces": "faces",
    "lip_mask": "faces",
    "inspect_video": "inspect",
    "apply_look": "paint",
    "estimate_look": "reference",
    "look_from_photo": "reference",
}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    check_memory(FIND_FACES)  # below that, their libraries crash while they are loaded
    return getattr(import_module(f"{__name__}.{_LATER[name]}"), name)
