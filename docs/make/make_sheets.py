"""Write docs/sheets.md and its pictures. The script keeps the text under the heading JUDGEMENT.

python docs/make/make_sheets.py
"""

from collections.abc import Callable, Sequence

import contact_sheet as sheet
import numpy as np
from makeup_video.pipeline import FINISHES, Look, product
from makeup_video.pipeline.look.look import ZONES

PAGE = sheet.DOCS / "sheets.md"
JUDGEMENT = "## What still looks wrong"
_RED, _PLUM, _BLUE, _WHITE = "B4002E", "4A1030", "0A2A8C", "F2EEEA"
_COLOURS = {
    "red": _RED, "nude": "B5705A", "plum": _PLUM, "blue": _BLUE, "black": "101012",
    "white": _WHITE,
}  # fmt: skip
_SHADOW = "6A3A5E"
_FACES = {"hopper": sheet.portrait, "astronaut": sheet.astronaut}
# Frames of samples/in.mp4.
_MOUTHS = {"closed": 0, "smile": 105, "talking": 213, "open": 207, "wide open": 190, "turned": 140}
_EYES = {"open": 0, "shut": 24}
_LIP_PRODUCTS = [("red", "matte"), ("red", "gloss"), ("plum", "satin"), ("black", "gloss"),
                 ("white", "matte"), ("blue", "metallic")]  # fmt: skip


def lips(colour: str, finish: str) -> Look:
    return Look(lips=product(sheet.rgb(_COLOURS[colour]), finish))


def draw_finishes(face: str) -> np.ndarray:
    return sheet.draw_looks(_lights(face), {finish: lips("red", finish) for finish in FINISHES})


def draw_colours(face: str) -> np.ndarray:
    return sheet.draw_looks(_lights(face), {colour: lips(colour, "satin") for colour in _COLOURS})


def draw_mouths() -> np.ndarray:
    scenes = {name: sheet.clip(number) for name, number in _MOUTHS.items()}
    return sheet.draw_looks(scenes, {f"{c}, {f}": lips(c, f) for c, f in _LIP_PRODUCTS})


def draw_shadow() -> np.ndarray:
    """Draw each zone on an open and a closed eye, then one eye behind glasses."""
    places = [(zone, name, sheet.clip(at)) for zone in ZONES for name, at in _EYES.items()]
    places.append(("full", "glasses", sheet.portrait()))
    cells = []
    for zone, _, scene in places:
        looks = [Look(eyes=product(sheet.rgb(_SHADOW), f, "eyes"), zone=zone) for f in FINISHES]
        cells.append([scene.closeup(look, sheet.EYE, sheet.CELL_WH) for look in (Look(), *looks)])
    return sheet.grid(cells, ["bare", *FINISHES], [f"{zone}, {name}" for zone, name, _ in places])


def _lights(face: str) -> dict[str, sheet.Scene]:
    return {light: _FACES[face]().in_light(light) for light in sheet.LIGHTS}


PICTURES: dict[str, Callable[[], np.ndarray]] = {
    f"lips-{kind}-{face}.jpg": (lambda face=face, draw_kind=draw_kind: draw_kind(face))
    for kind, draw_kind in (("finishes", draw_finishes), ("colours", draw_colours))
    for face in _FACES
} | {
    "lips-mouths.jpg": draw_mouths,
    "eye-shadow.jpg": draw_shadow,
}


def _codes(names: Sequence[str]) -> str:
    return ", ".join(f"{name} #{_COLOURS[name]}" for name in names)


def text() -> str:
    """Return the page down to the heading JUDGEMENT."""
    return f"""# Looks on faces

<!-- Written by docs/make/make_sheets.py (extra: samples), down to the last heading. -->

Nothing is retouched: each cell is a part of a picture that `apply_look` painted.
The faces are those of the samples; `samples/README.md` gives their origin.
The effect of each parameter: [parameters.md](parameters.md). Ready looks: [ready.md](ready.md).

## Finishes in different light

Red (#{_RED}) in every finish. The rows show the photograph as it is, with 0.5 and 1.6 times the
light, and in warm and cool light. The light was changed in linear RGB before painting. Values that
are too bright clip, as in a camera.

Older skin and thin, closed lips:

{sheet.picture("lips-finishes-hopper")}

A smile that shows teeth:

{sheet.picture("lips-finishes-astronaut")}

## Colours in different light

Satin: {_codes(list(_COLOURS))}.

{sheet.picture("lips-colours-hopper")}

{sheet.picture("lips-colours-astronaut")}

## Mouths

Frames of `samples/in.mp4`, whose teeth and tongue are drawn. Colours:
{_codes(["red", "plum", "black", "white", "blue"])}.

{sheet.picture("lips-mouths")}

## Eyeshadow

#{_SHADOW} in each zone and finish, on an open and on a closed eye (frames of `samples/in.mp4`).
The last row shows an eye behind glasses.

{sheet.picture("eye-shadow")}

{JUDGEMENT}
"""


def kept_judgement() -> str:
    """Return the text of the present page under the heading JUDGEMENT, or ""."""
    return sheet.kept_after(PAGE, JUDGEMENT)


if __name__ == "__main__":
    sheet.take_no_options(__doc__)
    PAGE.write_text(text() + kept_judgement(), encoding="utf-8")
    sheet.save_all(PICTURES)
