"""A photo to paint on: its faces, found once, at the size of the page and at full size."""

from collections.abc import Callable
from functools import cached_property

import cv2
import numpy as np
from makeup_video.pipeline.errors import PhotoError
from makeup_video.pipeline.faces.face import Face, resized
from makeup_video.pipeline.images.photo_file import read_photo
from makeup_video.pipeline.look.look import Look

WHOLE_PX = 2400  # longer side; each session keeps one of these: 17 MB at most
SHOWN_PX = 1200  # longer side of the picture on the page
_JPEG = (
    cv2.IMWRITE_JPEG_QUALITY, 90,
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
)  # fmt: skip


class Portrait:
    """A photo and its faces. Methods are slow, and only one thread may use them at a time."""

    def __init__(
        self, photo: bytes, name: str, read: Callable[[bytes, str], np.ndarray] = read_photo
    ) -> None:
        """Decode a photo and find its faces.

        photo: a file's bytes, called `name` in messages.  read: decodes the photo.
        Raises InputError, and PhotoError when there is no face.
        """
        from makeup_video.pipeline import find_faces

        self._whole = _no_larger(read(photo, name), WHOLE_PX)
        self._faces = find_faces(self._whole)
        if not self._faces:
            raise PhotoError(
                f"{name}: no face was found: give a photo that shows one upright, larger or "
                "brighter"
            )

    def painted(self, look: Look) -> bytes:
        """Paint a look at the page's size, and return the JPEG."""
        from makeup_video.pipeline import apply_look

        shown, faces = self._shown
        return _jpeg(apply_look(shown, look, faces))

    def painted_whole(self, look: Look) -> np.ndarray:
        """Paint a look at full size: (H, W, 3) uint8 RGB."""
        from makeup_video.pipeline import apply_look

        return apply_look(self._whole, look, self._faces)

    @cached_property
    def bare(self) -> bytes:
        """The photo without makeup at the page's size, as JPEG."""
        return _jpeg(self._shown[0])

    @cached_property
    def _shown(self) -> tuple[np.ndarray, tuple[Face, ...]]:
        small = _no_larger(self._whole, SHOWN_PX)
        down, across = (
            new / old for new, old in zip(small.shape[:2], self._whole.shape[:2], strict=True)
        )
        return small, tuple(resized(face, across, down) for face in self._faces)


def _no_larger(rgb8: np.ndarray, longer_px: int) -> np.ndarray:
    h, w = rgb8.shape[:2]
    scale = longer_px / max(h, w)
    if scale >= 1:
        return rgb8
    size_wh = max(1, round(scale * w)), max(1, round(scale * h))
    return cv2.resize(rgb8, size_wh, interpolation=cv2.INTER_AREA)


def _jpeg(rgb8: np.ndarray) -> bytes:
    _, data = cv2.imencode(".jpg", rgb8[..., ::-1], _JPEG)
    return data.tobytes()
