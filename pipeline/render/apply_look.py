"""Paints looks on RGB pictures in memory."""

import threading
from collections.abc import Iterable

import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces, check_faces, sound_faces
from makeup_video.pipeline.faces.find import find_faces_in_frame
from makeup_video.pipeline.frames.rgb import merge, to_frame
from makeup_video.pipeline.frames.views import check_paintable
from makeup_video.pipeline.look.look import Look, check_look
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.opencl import once_a_process


def apply_look(rgb8: np.ndarray, look: Look, faces: Iterable[Face] | None = None) -> np.ndarray:
    """A picture with the look painted on its faces; pixels that nobody paints keep their values.

    rgb8: (H, W, 3) uint8, upright, R'G'B' as sRGB encodes it, less than 268 million px; it is not
    changed.
    faces: the faces to paint, as `find_faces` found them in this very picture. Faces with numbers
    that are not finite, or beyond a million px, are left alone. None: all faces in the picture,
    found in its Y'CbCr codes, as in videos, and so a little apart from where `find_faces` finds
    them.
    Returns a new (H, W, 3) uint8 array, encoded like rgb8; a plain copy when there is no face or
    the look is bare.  Raises ValueError for another shape or dtype, TypeError for a look of another
    type and for faces that are not faces, InstallError when the face nets or OpenCL are missing,
    OutputError when no folder has room for compiled kernels.
    """
    paint: PaintPictures = _of_thread().paint
    return paint(rgb8, look, faces)


class PaintPictures:
    """Paints looks on pictures, one after the other, as `apply_look` does.

    The kernels stay loaded, which saves most of the time of a small picture. Only one thread at a
    time may use an instance.
    """

    def __init__(self) -> None:
        self._composite: Composite | None = None

    def __call__(
        self, rgb8: np.ndarray, look: Look, faces: Iterable[Face] | None = None
    ) -> np.ndarray:
        """Paint a look on a picture; arguments, result and errors are those of `apply_look`."""
        check_paintable(rgb8)
        check_look(look)
        if look.is_bare:
            return np.array(rgb8, order="C")
        stored = np.ascontiguousarray(rgb8[..., ::-1])
        frame = to_frame(stored)
        before = [plane.copy() for plane in frame.planes]
        if faces is None:
            item, _ = find_faces_in_frame(frame)
        else:
            item = FrameFaces(frame, check_faces(faces))
        sound = FrameFaces(frame, sound_faces(item))
        self._composite = self._composite or Composite(look)
        if self._composite.look is not look:  # set_look makes all charts be drawn anew
            self._composite.set_look(look)
        painted = self._composite(BuildScene()(sound))
        return np.ascontiguousarray(merge(stored, painted, before)[..., ::-1])


class _OfThread(threading.local):
    """PyOpenCL never frees all memory of a loaded kernel, so each thread keeps its kernels."""

    def __init__(self) -> None:
        self.paint = PaintPictures()


_of_thread = once_a_process(_OfThread)
