"""Paint close-ups of the samples and lay them out in labelled grids, for the pages in docs/.

Other programs of this folder use these functions; run by itself, this file draws nothing.
"""

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path

import av
import cv2
import numpy as np
from makeup_video.pipeline import Face, Look, apply_look, find_faces

DOCS = Path(__file__).parents[1]
SAMPLES = DOCS.parent / "samples"
PICTURES = "pictures"  # folder in DOCS
JPEG = [
    cv2.IMWRITE_JPEG_QUALITY, 88,
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    cv2.IMWRITE_JPEG_OPTIMIZE, 1,
]  # fmt: skip
CELL_WH = 200, 125
_LABEL_PX, _PAPER, _INK = 20, 255, (40, 40, 40)
_FONT, _FONT_SCALE, _CHARACTER_PX = cv2.FONT_HERSHEY_SIMPLEX, 0.42, 8

# The part of a face in a close-up: the points around its middle, and its width in distances between
# the outer eye corners.
What = tuple[Sequence[int], float]
MOUTH: What = (0, 17, 61, 291), 1.15
EYE: What = (33, 133, 159), 0.80  # with the brow
FACE: What = (33, 263, 1, 152), 2.1

# Factors of linear red, green and blue.
LIGHTS = {
    "as it is": (1.0, 1.0, 1.0),
    "light x 0.5": (0.5, 0.5, 0.5),
    "light x 1.6": (1.6, 1.6, 1.6),
    "warm": (1.25, 1.0, 0.62),
    "cool": (0.75, 1.0, 1.4),
}


class Scene:
    """A picture, (H, W, 3) uint8 encoded as sRGB, and its largest face."""

    def __init__(self, rgb8: np.ndarray, face: Face | None = None) -> None:
        self.rgb8 = rgb8
        self.face: Face = face or find_faces(rgb8)[0]

    def in_light(self, name: str) -> "Scene":
        """Return the scene in a light of LIGHTS. Values above 1 clip, as in a camera."""
        return Scene(encoded(np.clip(linear(self.rgb8) * np.float32(LIGHTS[name]), 0, 1)))

    def closeup(
        self,
        look: Look,
        what: What = MOUTH,
        size_wh: tuple[int, int] = (240, 150),
    ) -> np.ndarray:
        """Paint the look on the whole picture and return a part of it, (h, w, 3) uint8, as sRGB."""
        points, width = what
        xy = self.face.points_px[:, :2].astype(np.float64)
        middle = xy[list(points)].mean(0)
        scale = size_wh[0] / (width * float(np.hypot(*(xy[33] - xy[263]))))
        corner = middle - (np.array(size_wh) - 1) / 2 / scale
        to_cell = np.column_stack([np.eye(2) * scale, -corner * scale])
        painted = apply_look(self.rgb8, look, [self.face])
        flags = cv2.INTER_CUBIC if scale > 0.8 else cv2.INTER_AREA
        return cv2.warpAffine(painted, to_cell, size_wh, flags=flags)


def rgb(code: str) -> tuple[int, int, int]:
    """Return the code values of six hex digits: (180, 0, 46) for "B4002E"."""
    red, green, blue = bytes.fromhex(code)
    return red, green, blue


def linear(rgb8: np.ndarray) -> np.ndarray:
    """Convert sRGB codes to linear light in 0..1, float32 (IEC 61966-2-1)."""
    v = rgb8.astype(np.float32) / 255
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def encoded(light: np.ndarray) -> np.ndarray:
    """Convert linear light in 0..1 to sRGB codes, uint8."""
    v = np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.round(v * 255).astype(np.uint8)


def read(path: Path) -> np.ndarray:
    """Read a picture file as (H, W, 3) uint8, encoded as sRGB."""
    return np.ascontiguousarray(cv2.imread(str(path))[..., ::-1])


@cache
def portrait() -> Scene:
    """Return the portrait of Grace Hopper: older skin, thin lips, glasses."""
    return Scene(read(SAMPLES / "portrait.jpg"))


@cache
def astronaut() -> Scene:
    """Return the photograph of Eileen Collins, smiling, with a face as large as in a 720p video."""
    from skimage.data import astronaut  # in the extra `samples`

    return Scene(cv2.resize(astronaut(), None, fx=3, fy=3, interpolation=cv2.INTER_CUBIC))


@cache
def clip(index: int) -> Scene:
    """Return a frame of samples/in.mp4 by its number. Raises ValueError beyond the last frame."""
    with av.open(str(SAMPLES / "in.mp4")) as container:
        for number, frame in enumerate(container.decode(video=0)):
            if number == index:
                return Scene(frame.to_ndarray(format="rgb24"))
    raise ValueError(f"in.mp4 has no frame {index}")


def grid(
    cells: Sequence[Sequence[np.ndarray]], columns: Sequence[str], rows: Sequence[str] = ()
) -> np.ndarray:
    """Lay out rows of cells of equal size, (H, W, 3) uint8.

    columns: labels above the cells.  rows: labels to the left, or none.
    """
    height, width = cells[0][0].shape[:2]
    margin = _CHARACTER_PX * max(map(len, rows), default=0)
    lines = [np.hstack([_label("", margin, _LABEL_PX), *(_label(c, width) for c in columns)])]
    for number, row in enumerate(cells):
        name = _label(rows[number] if rows else "", margin, height)
        lines.append(np.hstack([name, *row]))
    return np.vstack(lines)


def draw_looks(
    scenes: Mapping[str, Scene],
    looks: Mapping[str, Look],
    what: What = MOUTH,
    size_wh: tuple[int, int] = CELL_WH,
) -> np.ndarray:
    """Draw a grid. Rows are scenes; columns are the bare face, then the looks."""
    looks = {"bare": Look(), **looks}
    cells = [
        [scene.closeup(look, what, size_wh) for look in looks.values()] for scene in scenes.values()
    ]
    return grid(cells, list(looks), list(scenes))


def _label(text: str, width: int, height: int = _LABEL_PX) -> np.ndarray:
    box = np.full((height, width, 3), _PAPER, np.uint8)
    if not text:
        return box
    (long, high), _ = cv2.getTextSize(text, _FONT, _FONT_SCALE, 1)
    at = (width - long) // 2, (height + high) // 2
    cv2.putText(box, text, at, _FONT, _FONT_SCALE, _INK, 1, cv2.LINE_AA)
    return box


def take_no_options(text: str) -> None:
    """Accept --help only, which prints the first paragraph of a docstring."""
    argparse.ArgumentParser(description=text.partition("\n\n")[0]).parse_args()


def save_all(pictures: dict[str, Callable[[], np.ndarray]]) -> None:
    """Draw each picture and write it under its file name. Raises OSError when a write fails."""
    for name, draw in pictures.items():
        write(DOCS / PICTURES / name, draw())


def write(path: Path, rgb8: np.ndarray) -> None:
    """Write a picture as JPEG, and print its size. Raises OSError when the write fails."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(path), rgb8[..., ::-1], JPEG):
        raise OSError(f"{path} cannot be written")
    print(f"{path.stat().st_size / 1000:4.0f} kB  {path}", flush=True)


def picture(name: str) -> str:
    """Return the Markdown for a picture of PICTURES. name: the file name without its ending."""
    return f"![{name}]({PICTURES}/{name}.jpg)"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def kept_after(page: Path, heading: str) -> str:
    """Return the text under a heading of a page, which people wrote by hand, or ""."""
    if not page.exists():
        return ""
    return page.read_text(encoding="utf-8").partition(heading + "\n")[2]


if __name__ == "__main__":
    take_no_options(__doc__.replace("\n\n", " ", 1))
