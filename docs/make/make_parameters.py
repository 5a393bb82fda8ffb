"""Write docs/parameters.md and its pictures from the code.

python docs/make/make_parameters.py
"""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any

import contact_sheet as sheet
import numpy as np
from makeup_video.pipeline import FINISHES, GraphicsParams, Look, product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.kind import Kind

PAGE = sheet.DOCS / "parameters.md"
STEPS = 5
# Frames of samples/in.mp4 with open and with closed eyes; the mouth is closed in both.
_OPEN, _SHUT = 0, 24
RED, PLUM, NUDE, PINK, BRONZE = "B4002E", "4A1030", "B5705A", "F0D0D8", "8A5A34"

_FINISHES = {
    "matte": "dry, with full coverage and no shine",
    "satin": "full coverage with a soft shine",
    "sheer": "a tint that lets the skin show through",
    "gloss": "wet, with sharp highlights and some reflection",
    "metallic": "full coverage with a broad bright sheen and fine sparkles of its own colour",
    "shimmer": "good coverage with sparkles",
}


@dataclass(frozen=True)
class Strip:
    """The product that a parameter is shown on; the parameter rises from 0 to `most`.

    eyes: adds a second row, with eyeshadow on a closed lid.  light: a key of
    contact_sheet.LIGHTS.  others: parameters that differ from those of the finish.
    """

    colour: str
    finish: str
    most: float = 1.0
    eyes: bool = False
    light: str = "as it is"
    others: Mapping[str, float] = field(default_factory=dict)

    def caption(self) -> str:
        where = "Lips and a closed lid" if self.eyes else "Lips"
        words = f"{where} in #{self.colour} {self.finish}"
        if self.others:
            settings = (f"{name} {value:g}" for name, value in self.others.items())
            words += f", with {' and '.join(settings)}"
        if self.light != "as it is":
            words += f", in {self.light} light"
        return f"{words}."


_MIRROR = {"gloss": 0.2, "reflection": 0.8}
STRIPS = {
    "red": Strip(RED, "satin", 255),
    "green": Strip(RED, "satin", 255),
    "blue": Strip(RED, "satin", 255),
    "opacity": Strip(RED, "satin", eyes=True),
    "gloss": Strip(RED, "gloss", 4, eyes=True),
    "gloss_roughness": Strip(RED, "gloss", others={"gloss": 2, "gloss_detail": 0.2}),
    "reflection": Strip(PLUM, "gloss", others={"gloss": 0.2}),
    "edge_softness": Strip(PLUM, "matte", eyes=True),
    "texture_keep": Strip(RED, "matte"),
    "undertone": Strip(NUDE, "satin", eyes=True),
    "gloss_detail": Strip(RED, "gloss", others={"gloss": 2}),
    "fresnel": Strip(PLUM, "gloss", others=_MIRROR),
    "environment_blur": Strip(PLUM, "gloss", others=_MIRROR),
    "shimmer": Strip(BRONZE, "shimmer", eyes=True),
    "shimmer_size": Strip(BRONZE, "shimmer", eyes=True),
    "shimmer_tint": Strip(BRONZE, "shimmer", others={"shimmer": 1}),
    "light_adaptation": Strip(PINK, "satin", light="warm"),
}


def draw_parameter(name: str) -> np.ndarray:
    strip = STRIPS[name]
    values = np.linspace(0, strip.most, STEPS)
    if strip.most == 255:
        values = values.round()
    shown = [("lips", _OPEN, sheet.MOUTH)] + ([("eyes", _SHUT, sheet.EYE)] if strip.eyes else [])
    cells = []
    for region, frame, what in shown:
        scene = sheet.clip(frame).in_light(strip.light)
        base = replace(product(sheet.rgb(strip.colour), strip.finish, region), **strip.others)
        looks = [Look(**{region: replace(base, **{name: float(value)})}) for value in values]
        cells.append([scene.closeup(look, what) for look in looks])
    return sheet.grid(cells, [f"{value:g}" for value in values])


def draw_strength() -> np.ndarray:
    params, values = product(sheet.rgb(RED), "satin"), np.linspace(0, 1, STEPS).tolist()
    scene = sheet.clip(_OPEN)
    cells = [scene.closeup(Look(lips=params, strength=value), sheet.MOUTH) for value in values]
    return sheet.grid([cells], [f"{value:g}" for value in values])


PICTURES = {f"{name}.jpg": (lambda name=name: draw_parameter(name)) for name in STRIPS} | {
    "strength.jpg": draw_strength,
}


def _parameter_row(spec: Any) -> list[str]:
    low, high = spec.metadata["low"], spec.metadata["high"]
    reach = f"{low:g} to {high:g}" if high < 1e6 else f"{low:g} or more, usually under 4"
    default = "required" if spec.default is MISSING else f"{spec.default:g}"
    return [f"`{spec.name}`", reach, default, spec.metadata["meaning"]]


def _finishes_of(kind: Kind) -> str:
    remark = f" ({kind.remark})" if kind.remark else ""
    return f"{kind.product}{remark}:\n\n{_finish_table(kind.part)}\n"


def _finish_table(part: str) -> str:
    settings = [
        spec.name for spec in fields(GraphicsParams) if spec.name in FINISHES["matte"][part]
    ]
    rows = [
        [f"`{name}`", *(f"{FINISHES[finish][part][name]:g}" for finish in FINISHES)]
        for name in settings
    ]
    return sheet.table(["", *FINISHES], rows)


def _picture(name: str, caption: str) -> str:
    return f"{sheet.picture(name)}\n\n{caption}"


def _section(spec: Any) -> str:
    picture = _picture(spec.name, STRIPS[spec.name].caption())
    return f"### {spec.name}\n\n{spec.metadata['meaning']}\n\n{picture}"


def text() -> str:
    """Return the whole page."""
    specs = fields(GraphicsParams)
    return f"""# Parameters of a look

<!-- Written by docs/make/make_parameters.py: change the code, not the page. -->

A product, of whatever kind of makeup, has {len(specs)} parameters. The seven required ones describe
the product itself. The others describe how the product is applied and how it responds to light.

{sheet.table(["name", "range", "default", "meaning"], [_parameter_row(spec) for spec in specs])}

A layer and the whole look have a `strength` besides, 0 to 1, which fades all of the product:

{_picture("strength", f"Lips in #{RED} satin.")}

Where a product lies is the shape of its layer: [kinds.md](kinds.md).

## Finishes

`--finish` sets every parameter except the colour.

{sheet.table(["finish", "appearance"], [[f"`{name}`", _FINISHES[name]] for name in FINISHES])}

{chr(10).join(_finishes_of(kind) for kind in KINDS.values())}
Finishes on faces and in different light: [sheets.md](sheets.md).

## What each parameter does

In each picture one parameter rises from left to right, and the others stay the same. The pictures
are parts of frames of `samples/in.mp4`, painted at 720p and then enlarged: a mouth 1.2 times, an
eye 1.8 times.

{(chr(10) * 2).join(_section(spec) for spec in specs)}
"""


if __name__ == "__main__":
    sheet.take_no_options(__doc__)
    PAGE.write_text(text(), encoding="utf-8")
    sheet.save_all(PICTURES)
