"""A photo to paint on, at the size of the page and at full size; its faces are found only once."""

from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.errors import PhotoError
from makeup_video.pipeline.faces.face import Face, resized
from makeup_video.pipeline.images.photo_file import read_photo
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.render.apply_look import PaintPictures
from makeup_video.web.small_picture import jpeg, scaled, small_jpeg

WHOLE_PX = 2400  # longer side of the photo that each session keeps: 17 MB at most
SHOWN_PX = 1200  # longer side of the picture on the page
THUMBNAIL_PX = 160  # side of a thumbnail, twice its side on the page in CSS pixels
# Thumbnails are painted at twice their size and averaged: otherwise a liner would be a pixel thin.
_FINER = 2
_AROUND = 1.05  # side of a thumbnail, as a multiple of the longer side of the face
OWN = Path(__file__).parent / "page" / "portrait.jpg"
MOST_THUMBNAILS = 200  # kept for a portrait, 10 kB each: those that were used last


class Portrait:
    """A photo and its faces. Methods are slow, and only one thread may use them at a time."""

    def __init__(self, rgb8: np.ndarray, name: str) -> None:
        """Find the faces of a photo.

        rgb8: (H, W, 3) uint8, encoded as sRGB.  name: what messages call the photo.
        Raises PhotoError when there is no face.
        """
        from makeup_video.pipeline import find_faces

        self._whole = scaled(rgb8, WHOLE_PX / max(rgb8.shape[:2]))
        self._faces = find_faces(self._whole)
        if not self._faces:
            raise PhotoError(
                f"{name}: no face was found: give a photo that shows one upright, larger or "
                "brighter"
            )
        self._paint = PaintPictures()
        self._thumbnails: dict[Look, bytes] = {}

    def painted(self, look: Look) -> bytes:
        """Paint a look at the page's size, and return the picture as JPEG."""
        shown, faces = self._shown
        return jpeg(self._paint(shown, look, faces))

    def painted_whole(self, look: Look) -> np.ndarray:
        """Paint a look at full size: (H, W, 3) uint8 RGB."""
        return self._paint(self._whole, look, self._faces)

    def thumbnail(self, look: Look) -> bytes:
        """The largest face with a look: a square JPEG of THUMBNAIL_PX, kept for the next time."""
        made = self._thumbnails.pop(look, None) or self._thumbnail(look)
        self._thumbnails[look] = made  # goes to the end: the dict is in the order of last use
        if len(self._thumbnails) > MOST_THUMBNAILS:
            del self._thumbnails[next(iter(self._thumbnails))]
        return made

    def _thumbnail(self, look: Look) -> bytes:
        small, face, (top, left, side) = self._close_up
        painted = self._paint(small, look, [face])[top : top + side, left : left + side]
        size_wh = THUMBNAIL_PX, THUMBNAIL_PX
        return jpeg(cv2.resize(painted, size_wh, interpolation=cv2.INTER_AREA))

    @cached_property
    def _close_up(self) -> tuple[np.ndarray, Face, tuple[int, int, int]]:
        """The photo, scaled down to the size that thumbnails need; its largest face; and the square
        around that face as (top, left, side) in px."""
        points_px = self._faces[0].points_px[:, :2]
        low, high = points_px.min(0), points_px.max(0)
        wide_px = _AROUND * float((high - low).max())
        small, (face,) = _shrunk(self._whole, self._faces[:1], _FINER * THUMBNAIL_PX / wide_px)
        scale = small.shape[1] / self._whole.shape[1]
        side = min(round(wide_px * scale), *small.shape[:2])
        across, down = (low + high) / 2 * scale
        top, left = (
            int(np.clip(round(middle - side / 2), 0, length - side))
            for middle, length in zip((down, across), small.shape[:2], strict=True)
        )
        return small, face, (top, left, side)

    def painted_and_bare(self, look: Look) -> np.ndarray:
        """The photo without makeup on the left, with a look on the right, at full size."""
        return np.hstack([self._whole, self.painted_whole(look)])

    @cached_property
    def small(self) -> bytes:
        """The photo without makeup as a thumbnail, as JPEG."""
        return small_jpeg(self._whole)

    @cached_property
    def bare(self) -> bytes:
        """The photo without makeup at the page's size, as JPEG."""
        return jpeg(self._shown[0])

    @cached_property
    def _shown(self) -> tuple[np.ndarray, tuple[Face, ...]]:
        return _shrunk(self._whole, self._faces, SHOWN_PX / max(self._whole.shape[:2]))


def own_portrait() -> Portrait:
    """The portrait that ships with the page."""
    return Portrait(read_photo(OWN), OWN.name)


def _shrunk(
    rgb8: np.ndarray, faces: tuple[Face, ...], scale: float
) -> tuple[np.ndarray, tuple[Face, ...]]:
    """A picture and its faces, scaled down; a scale of 1 or more leaves both as they are."""
    small = scaled(rgb8, scale)
    down, across = (new / old for new, old in zip(small.shape[:2], rgb8.shape[:2], strict=True))
    return small, tuple(resized(face, across, down) for face in faces)
