"""makeup-video as a library.

from makeup_video.pipeline import Look, find_faces, lip_mask, process_video
report = process_video("in.mp4", "out.mp4", Look.load("look.json"))
faces = find_faces(rgb8)  # largest first
weight = lip_mask(rgb8, faces[0])
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from makeup_video.pipeline.errors import (
    DecodeError,
    EncodeError,
    InputError,
    InstallError,
    LookError,
    MakeupVideoError,
    OutputError,
    StoppedError,
    StrictError,
    UsageError,
)
from makeup_video.pipeline.face import Face, FrameFaces, LipPatch
from makeup_video.pipeline.frame import ColourTags, Frame
from makeup_video.pipeline.look import GraphicsParams, Look
from makeup_video.pipeline.process import Settings, process_video
from makeup_video.pipeline.report import Report

__all__ = [
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
    "Report",
    "Settings",
    "StoppedError",
    "StrictError",
    "UsageError",
    "find_faces",
    "inspect_video",
    "lip_mask",
    "process_video",
]

if TYPE_CHECKING:
    from makeup_video.pipeline.faces import FindFaces, find_faces, lip_mask
    from makeup_video.pipeline.inspect import inspect_video

# ONNX Runtime and OpenCV take half a second to import: only for those who look for faces.
_LATER = {
    "FindFaces": "faces",
    "find_faces": "faces",
    "lip_mask": "faces",
    "inspect_video": "inspect",
}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_LATER[name]}"), name)
