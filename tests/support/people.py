"""Frames and pictures of people, from the repository's own samples."""

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from itertools import islice
from pathlib import Path

import av
import cv2
import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from media import add_video

SAMPLES = Path(__file__).parents[2] / "samples"
TICK = Fraction(1, 30)


@cache
def portrait() -> np.ndarray:
    """(600, 512, 3) uint8 RGB: one bare face, about 210 px wide."""
    bgr8 = cv2.imread(str(SAMPLES / "portrait.jpg"))
    half = cv2.resize(bgr8, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(half[..., ::-1])


@cache
def clip(count: int = 40) -> tuple[np.ndarray, ...]:
    """The first frames of the sample, 640 x 360 RGB; one face, about 120 px wide."""
    with av.open(str(SAMPLES / "in.mp4")) as container:
        pictures = []
        for picture in container.decode(video=0):
            pictures.append(picture.to_ndarray(format="rgb24", width=640, height=360))
            if len(pictures) == count:
                break
    return tuple(pictures)


@cache
def clip_points(count: int = 40) -> np.ndarray:
    """(count, 478, 2) true points in `clip`, px."""
    stored = np.load(SAMPLES / "in_points.npz")
    points = stored["points"][:count].astype(np.float64) * stored["unit"]
    return (points + 0.5) / 2 - 0.5


def frame_of(
    rgb8: np.ndarray,
    pts: int = 0,
    pix_fmt: str = "yuv420p",
    *,
    time_base: Fraction = TICK,
    matrix: int = 1,
    full_range: bool = False,
    rotation_degrees: int = 0,
) -> Frame:
    """An upright RGB picture as the stored frame of a camera that is turned by -rotation."""
    stored = np.rot90(rgb8, -rotation_degrees // 90)
    picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(stored), format="rgb24").reformat(
        format=pix_fmt,
        dst_colorspace=Colorspace(matrix),
        dst_color_range=ColorRange.JPEG if full_range else ColorRange.MPEG,
    )
    tags = ColourTags(matrix, 2 if full_range else 1, 1, 1)
    return Frame(picture, pts, time_base, tags, rotation_degrees)


def veiled(rgb8: np.ndarray) -> np.ndarray:
    """The same picture with its one face's mouth behind a veil."""
    points = find_faces(rgb8)[0].points_px[:, :2].astype(int)
    left, right, nose, chin = points[234, 0], points[454, 0], points[1, 1], points[152, 1]
    out = rgb8.copy()
    out[nose + (chin - nose) // 4 : chin + 20, left:right] = (120, 180, 200)
    return out


def write_video(
    path: Path,
    pictures: Sequence[np.ndarray],
    pix_fmt: str = "yuv420p",
    rotation_degrees: int = 0,
    options: dict[str, str] | None = None,
) -> Path:
    """Upright RGB pictures as a lossless video, stored with a rotation and its tag.

    options: of the encoder.
    """
    with av.open(str(path), "w") as out:
        height, width = np.rot90(pictures[0], rotation_degrees // 90).shape[:2]
        stream = add_video(out, "ffv1", size_wh=(width, height), pix_fmt=pix_fmt, options=options)
        if rotation_degrees:
            stream.set_display_rotation(rotation_degrees)
        for index, rgb8 in enumerate(pictures):
            shown = frame_of(rgb8, index, pix_fmt, rotation_degrees=rotation_degrees).picture
            shown.pts, shown.time_base = index, TICK
            out.mux(stream.encode(shown))
        out.mux(stream.encode(None))
    return path


def resized_sample(
    path: Path, size_wh: tuple[int, int], frames: int, every: int = 1, rate: int = 30
) -> Path:
    """The first frames of the sample, or each second one and so on, at another size and rate."""
    with av.open(str(SAMPLES / "in.mp4")) as source, av.open(str(path), "w") as out:
        stream = add_video(out, size_wh=size_wh, rate=rate)
        pictures = islice(source.decode(video=0), 0, frames * every, every)
        for number, picture in enumerate(pictures):
            resized = picture.reformat(*size_wh)
            resized.pts, resized.time_base = number, Fraction(1, rate)
            resized.pict_type = 0  # the encoder's own choice
            out.mux(stream.encode(resized))
        out.mux(stream.encode(None))
    return path


def put(ground: np.ndarray, picture: np.ndarray, x: int, y: int) -> np.ndarray:
    """A copy of `ground` with the top left corner of `picture` at (x, y); the rest is cut off."""
    out = ground.copy()
    h, w = picture.shape[:2]
    x0, y0 = max(x, 0), max(y, 0)
    x1, y1 = min(x + w, out.shape[1]), min(y + h, out.shape[0])
    if x1 > x0 and y1 > y0:
        out[y0:y1, x0:x1] = picture[y0 - y : y1 - y, x0 - x : x1 - x]
    return out


def face_of(size_px: int) -> np.ndarray:
    """The portrait, square, scaled so that its face is about size_px wide."""
    square = portrait()[60:500, 40:480]
    side = round(size_px * 440 / 210)
    return cv2.resize(square, (side, side), interpolation=cv2.INTER_AREA)


def grey(width_px: int = 640, height_px: int = 360) -> np.ndarray:
    return np.full((height_px, width_px, 3), 110, np.uint8)
