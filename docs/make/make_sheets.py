"""Writes docs/sheets.md and its pictures: python docs/make/make_sheets.py

What is written in the page under JUDGEMENT stays.
"""

from collections.abc import Callable, Mapping, Sequence

import contact_sheet as sheet
import numpy as np
from makeup_video.pipeline import FINISHES, Look, product
from makeup_video.pipeline.look.regions.eyes import ZONES

PAGE = sheet.DOCS / "sheets.md"
JUDGEMENT = "## What still looks wrong"
_CELL_WH = 200, 125
_RED, _PLUM, _BLUE, _WHITE = "B4002E", "4A1030", "0A2A8C", "F2EEEA"
_COLOURS = {"red": _RED, "nude": "B5705A", "plum": _PLUM, "blue": _BLUE, "black": "101012", "white": _WHITE}  # fmt: skip
_SHADOW = "6A3A5E"
_FACES = {"hopper": sheet.portrait, "astronaut": sheet.astronaut}
# Frames of samples/in.mp4, by what they show
_MOUTHS = {"closed": 0, "smile": 105, "talking": 213, "open": 207, "wide open": 190, "turned": 140}
_EYES = {"open": 0, "shut": 24}
_LIP_PRODUCTS = [("red", "matte"), ("red", "gloss"), ("plum", "satin"), ("black", "gloss"),
                 ("white", "matte"), ("blue", "metallic")]  # fmt: skip


def lips(colour: str, finish: str) -> Look:
    return Look(lips=product(sheet.rgb(_COLOURS[colour]), finish))


def draw(
    scenes: Mapping[str, sheet.Scene], looks: Mapping[str, Look], what: sheet.What = sheet.MOUTH
) -> np.ndarray:
    """Rows are scenes; columns are looks, after the bare face."""
    looks = {"bare": Look(), **looks}
    cells = [[scene.closeup(look, what, _CELL_WH) for look in looks.values()] for scene in scenes.values()]  # fmt: skip
    return sheet.grid(cells, list(looks), list(scenes))


def draw_finishes(face: str) -> np.ndarray:
    return draw(_lights(face), {finish: lips("red", finish) for finish in FINISHES})


def draw_colours(face: str) -> np.ndarray:
    return draw(_lights(face), {colour: lips(colour, "satin") for colour in _COLOURS})


def draw_mouths() -> np.ndarray:
    scenes = {name: sheet.clip(number) for name, number in _MOUTHS.items()}
    return draw(scenes, {f"{c}, {f}": lips(c, f) for c, f in _LIP_PRODUCTS})


def draw_shadow() -> np.ndarray:
    """Each zone on an eye that is open and on one that is shut; and one behind glasses."""
    places = [(zone, name, sheet.clip(at)) for zone in ZONES for name, at in _EYES.items()]
    places.append(("full", "glasses", sheet.portrait()))
    cells = []
    for zone, _, scene in places:
        looks = [Look(eyes=product(sheet.rgb(_SHADOW), f, "eyes"), zone=zone) for f in FINISHES]
        cells.append([scene.closeup(look, sheet.EYE, _CELL_WH) for look in (Look(), *looks)])
    return sheet.grid(cells, ["bare", *FINISHES], [f"{zone}, {name}" for zone, name, _ in places])


def _lights(face: str) -> dict[str, sheet.Scene]:
    return {light: _FACES[face]().in_light(light) for light in sheet.LIGHTS}


PICTURES: dict[str, Callable[[], np.ndarray]] = {
    f"lips-{kind}-{face}.jpg": (lambda face=face, draw_kind=draw_kind: draw_kind(face))
    for kind, draw_kind in (("finishes", draw_finishes), ("colours", draw_colours))
    for face in _FACES
} | {"lips-mouths.jpg": draw_mouths, "eye-shadow.jpg": draw_shadow}


def _picture(name: str) -> str:
    return f"![{name}]({sheet.PICTURES}/{name}.jpg)"


def _codes(names: Sequence[str]) -> str:
    return ", ".join(f"{name} #{_COLOURS[name]}" for name in names)


def text() -> str:
    """The page, down to the judgement."""
    return f"""# Sheets: looks on faces

Made by `python docs/make/make_sheets.py` (it needs the extra `samples`). Nothing is retouched: each cell is a part of a
picture that `apply_look` painted. The faces are those of the samples; `samples/README.md` says where they are from.
What the parameters do one by one: [parameters.md](parameters.md).

## Finishes in different light

Red (#{_RED}) in every finish. Rows: the photograph as it is; with half and 1.6 times the light; in warm and
in cool light. Light was changed in linear light before painting, and clips where a camera's would.

Older skin, thin closed lips:

{_picture("lips-finishes-hopper")}

A smile, teeth showing:

{_picture("lips-finishes-astronaut")}

## Colours in different light

Satin: {_codes(list(_COLOURS))}.

{_picture("lips-colours-hopper")}

{_picture("lips-colours-astronaut")}

## Mouths

Frames of `samples/in.mp4`, its teeth and tongue being drawn: {_codes(["red", "plum", "black", "white", "blue"])}.

{_picture("lips-mouths")}

## Eye-shadow

#{_SHADOW} in each zone and finish, on an eye that is open and on one that is shut (frames of `samples/in.mp4`);
the last row is an eye behind glasses.

{_picture("eye-shadow")}

{JUDGEMENT}
"""


def kept_judgement() -> str:
    """What the page says under its last heading."""
    if not PAGE.exists():
        return ""
    return PAGE.read_text(encoding="utf-8").partition(JUDGEMENT + "\n")[2]


if __name__ == "__main__":
    PAGE.write_text(text() + kept_judgement(), encoding="utf-8")
    sheet.save_all(PICTURES)
