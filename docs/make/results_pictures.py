"""Draw pictures and clips of looks that were read from photos, for make_results.py."""

from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import contact_sheet as sheet
import cv2
import numpy as np
from makeup_video.pipeline import GraphicsParams, Look, Settings, apply_look, process_video, product
from makeup_video.training.reference.augment import jpeg
from makeup_video.training.reference.rendered_crops import TEST_QUALITY

if TYPE_CHECKING:
    from makeup_video.training.reference.read_look import Net
    from makeup_video.training.reference.triplets import Triplet

_CELL_WH = {"lips": (200, 125), "eyes": (240, 90)}
EYES: sheet.What = ((33, 263, 9, 8), 1.75)
_WHAT = {"lips": sheet.MOUTH, "eyes": EYES}
# The grids: a region and its products, each a colour and a finish.
GRIDS: dict[str, tuple[str, tuple[tuple[str, str], ...]]] = {
    "results-lips.jpg": ("lips", (
        ("B4002E", "matte"), ("C8325A", "gloss"), ("B5705A", "satin"), ("4A1030", "satin"),
        ("9A4A3A", "metallic"),
    )),
    "results-eyes.jpg": ("eyes", (
        ("6A3A5E", "satin"), ("3A2418", "matte"), ("A8784A", "metallic"), ("C890A0", "shimmer"),
        ("2E4A3C", "satin"),
    )),
    "results-extreme-lips.jpg": ("lips", (
        ("1432C8", "satin"), ("1E8C32", "matte"), ("101012", "gloss"), ("F2EEEA", "matte"),
        ("F0CD1E", "satin"),
    )),
    "results-extreme-eyes.jpg": ("eyes", (
        ("1432C8", "matte"), ("1E8C32", "metallic"), ("101012", "matte"), ("F2EEEA", "shimmer"),
        ("F0CD1E", "satin"),
    )),
}  # fmt: skip
_SHUT = 24  # frame of samples/in.mp4 with closed eyes
_COLUMNS = ("reference", "bare", "read from it", "truth")
_CLIPS = {
    "lipstick.mp4": ("lips", "8C1446", "gloss"),
    "eye-shadow.mp4": ("eyes", "5A3A78", "shimmer"),
}


def markdown() -> str:
    return "\n\n".join(sheet.picture(name.removesuffix(".jpg")) for name in GRIDS)


def worn(region: str, code: str, finish: str) -> Look:
    made: dict[str, GraphicsParams] = {region: product(sheet.rgb(code), finish, region)}
    return Look(**made, zone="full" if region == "eyes" else "lid")


@cache
def hopper() -> sheet.Scene:
    """Return Hopper at half size: her face is then about as wide as the faces in training."""
    whole = sheet.portrait().rgb8
    return sheet.Scene(cv2.resize(whole, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))


def wearer(region: str) -> sheet.Scene:
    """Return the face of the reference. Hopper's lids are behind the rims of her glasses."""
    return hopper() if region == "lips" else sheet.astronaut()


def other(region: str) -> sheet.Scene:
    """Return the bare face on which the look is painted."""
    return sheet.astronaut() if region == "lips" else sheet.clip(_SHUT)


def photo_of(look: Look, region: str) -> np.ndarray:
    """Paint the reference photo and save it as JPEG, (H, W, 3) uint8."""
    scene = wearer(region)
    return jpeg(apply_look(scene.rgb8, look, [scene.face]), TEST_QUALITY)


def read_from(photo: np.ndarray, look: Look, nets: Mapping[str, "Net"]) -> Look:
    """Read the regions that the true look has from the photo, in the zone of the true look."""
    from makeup_video.training.reference.read_look import paper_look
    from makeup_video.training.reference.triplets import worn as regions_of

    chosen = {region: nets[region] for region in regions_of(look)}
    return paper_look(photo, chosen, look.zone) or Look()


def draw(name: str, nets: Mapping[str, "Net"]) -> np.ndarray:
    """Draw a grid with a row for each product, (H, W, 3) uint8."""
    region, products = GRIDS[name]
    what, size_wh = _WHAT[region], _CELL_WH[region]
    cells = []
    for code, finish in products:
        look = worn(region, code, finish)
        photo = photo_of(look, region)
        read = read_from(photo, look, nets)
        reference = sheet.Scene(photo).closeup(Look(), what, size_wh)
        others = (other(region).closeup(one, what, size_wh) for one in (Look(), read, look))
        cells.append([reference, *others])
    return sheet.grid(cells, _COLUMNS, [f"#{code}, {finish}" for code, finish in products])


def save_all(nets: Mapping[str, "Net"], folder: Path) -> None:
    for name, (region, _) in GRIDS.items():
        if region in nets:
            sheet.write(folder / name, draw(name, nets))


def save_test_people(
    made: Iterable["Triplet"], region: str, nets: Mapping[str, "Net"], folder: Path
) -> None:
    """Draw a similar grid of test people, with the moved mean colour. No page shows this grid."""
    from makeup_video.training.reference.baselines import transfer_mean_colour
    from makeup_video.training.reference.rendered_crops import to_rgb8
    from makeup_video.training.reference.triplets import weight_of

    what, size_wh = _WHAT[region], _CELL_WH[region]
    cells = []
    for one in made:
        reference = sheet.Scene(one.photo, one.wearer.scene.faces[0].face)
        bare = sheet.Scene(to_rgb8(one.bare.codes), one.bare.scene.faces[0].face)
        read = read_from(one.photo, one.look, nets)
        there, here = (
            weight_of(each.face, region, one.look.zone, each.rgb8.shape[1::-1])
            for each in (reference, bare)
        )
        moved = transfer_mean_colour(one.photo, there, bare.rgb8, here)
        views = [(reference, Look()), (bare, Look()), (sheet.Scene(moved, bare.face), Look())]
        views += [(bare, read), (bare, one.look)]
        cells.append([scene.closeup(look, what, size_wh) for scene, look in views])
    columns = ("reference", "bare", "mean colour", "read from it", "truth")
    sheet.write(folder / f"test-people-{region}.jpg", sheet.grid(cells, columns))


def save_clips(nets: Mapping[str, "Net"], folder: Path) -> None:
    """Paint samples/in.mp4 with a lipstick and an eyeshadow that were read from photos."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, (region, code, finish) in _CLIPS.items():
        look = worn(region, code, finish)
        photo = photo_of(look, region)
        sheet.write((folder / name).with_suffix(".reference.jpg"), photo)
        read = read_from(photo, look, nets)
        read.save((folder / name).with_suffix(".look.json"))
        process_video(sheet.SAMPLES / "in.mp4", folder / name, read, Settings(overwrite=True))
        print(folder / name, flush=True)
