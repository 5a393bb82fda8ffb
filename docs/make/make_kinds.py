"""Write docs/kinds.md and its pictures from the registry of kinds.

python docs/make/make_kinds.py
"""

from collections.abc import Callable
from typing import Any

import contact_sheet as sheet
import numpy as np
from makeup_video.pipeline import FINISHES, KINDS, Layer, Look, product
from makeup_video.pipeline.look.kinds import density_map
from makeup_video.pipeline.look.kinds.kind import Dial, Kind
from makeup_video.pipeline.look.params import hex_of

PAGE = sheet.DOCS / "kinds.md"
STEPS = 5
_OPEN = 0  # a frame of samples/in.mp4 with open eyes and a closed mouth
# For each region: the part of the face to show, and the frames. Eyes also need closed lids.
_SHOWN: dict[str, tuple[sheet.What, tuple[int, ...]]] = {
    "lips": (sheet.MOUTH, (_OPEN,)),
    "eyes": (sheet.EYE, (_OPEN, 24)),
    "face": (sheet.FACE, (_OPEN,)),
}


def look_of(kind: Kind, shape: dict[str, Any], finish: str | None = None) -> Look:
    """A look of one layer in the kind's first colour."""
    worn = product(kind.first_rgb, finish or kind.first_finish, kind.part)
    return Look([Layer(kind.name, worn, shape)])


def _row(kind: Kind, looks: list[Look], frame: int) -> list[np.ndarray]:
    what, _ = _SHOWN[kind.region]
    return [sheet.clip(frame).closeup(look, what, sheet.CELL_WH) for look in looks]


def draw_finishes(kind: Kind) -> np.ndarray:
    """Draw the kind in every finish."""
    return _beside_bare(kind, {finish: look_of(kind, {}, finish) for finish in FINISHES})


def draw_slots(kind: Kind) -> np.ndarray:
    """Draw every named place of the kind."""
    return _beside_bare(kind, {slot: look_of(kind, {"slot": slot}) for slot in kind.slots})


def _beside_bare(kind: Kind, looks: dict[str, Look]) -> np.ndarray:
    """Draw the bare face and the looks in every frame that shows the kind."""
    frames = _SHOWN[kind.region][1]
    cells = [_row(kind, [Look(), *looks.values()], frame) for frame in frames]
    return sheet.grid(cells, ["bare", *looks])


def draw_dials(kind: Kind) -> np.ndarray:
    """Draw each number of the shape as it rises from left to right. The others keep a value at
    which the number shows."""
    rows = [dial for dial in kind.dials if _is_number(dial)]
    cells = []
    for dial in rows:
        values = np.linspace(dial.low, dial.high, STEPS).tolist()
        looks = [look_of(kind, {**kind.shown, dial.name: value}) for value in values]
        cells.append(_row(kind, looks, _OPEN))
    share = [f"{step / (STEPS - 1):.0%}" for step in range(STEPS)]
    return sheet.grid(cells, share, [dial.name for dial in rows])


def _is_number(dial: Dial) -> bool:
    return not (dial.choices or dial.is_colour or dial.is_map)


def _pictures() -> dict[str, Callable[[], np.ndarray]]:
    drawn: dict[str, Callable[[], np.ndarray]] = {}
    for kind in KINDS.values():
        drawn[f"{kind.name}-finishes.jpg"] = lambda kind=kind: draw_finishes(kind)
        if kind.slots:
            drawn[f"{kind.name}-slots.jpg"] = lambda kind=kind: draw_slots(kind)
        drawn[f"{kind.name}-shape.jpg"] = lambda kind=kind: draw_dials(kind)
    return drawn


PICTURES = _pictures()


def _dial_row(dial: Dial) -> list[str]:
    if dial.choices:
        reach = ", ".join(f"`{choice}`" for choice in dial.choices)
    elif dial.is_colour:
        reach = "six hex digits"
    elif dial.is_map:
        reach = f"{density_map.HW[0]} rows of {density_map.HW[1]} characters"
    else:
        reach = f"{dial.low:g} to {dial.high:g}"
    unit = f" ({dial.unit})" if dial.unit else ""
    default = f"`{dial.default}`" if isinstance(dial.default, str) else f"{dial.default:g}"
    if dial.is_map:
        default = "none"
    return [f"`{dial.name}`", reach + unit, default, dial.meaning]


def _slots(kind: Kind) -> str:
    if not kind.slots:
        return ""
    names = list(next(iter(kind.slots.values())))
    rows = [
        [f"`{slot}`", *(f"{numbers[name]:g}" for name in names)]
        for slot, numbers in kind.slots.items()
    ]
    return f"""
Each zone (`slot`) stands for these values; a value that is given overrides that of the zone:

{sheet.table(["zone", *names], rows)}

{sheet.picture(f"{kind.name}-slots")}
"""


def _section(kind: Kind) -> str:
    layers = "one layer" if kind.most == 1 else f"up to {kind.most} layers"
    return f"""## {kind.product}

`{kind.name}`; as a part of a look `{kind.part}`, so `--{kind.part} '#RRGGBB:finish'`. A look has
{layers} of it{" on each eye" if kind.has_eyes else ""}.

{sheet.table(["shape", "range", "default", "meaning"], [_dial_row(dial) for dial in kind.dials])}
{_slots(kind)}
Each shape parameter from its lowest to its highest value:

{sheet.picture(f"{kind.name}-shape")}

The finishes, in {hex_of(kind.first_rgb)}:

{sheet.picture(f"{kind.name}-finishes")}
"""


def text() -> str:
    """Return the whole page."""
    kinds = ", ".join(f"`{name}`" for name in sorted(KINDS, key=lambda name: KINDS[name].order))
    return f"""# Kinds of makeup

<!-- Written by docs/make/make_kinds.py: change the code, not the page. -->

A look is a list of layers. A layer has a kind, a product (its 17 parameters:
[parameters.md](parameters.md)), a shape and a strength. Whatever their order in the file, layers
are painted in this order:
{kinds}.
Layers of one kind keep their order. The look file: [looks.md](looks.md).

The pictures are parts of frames of `samples/in.mp4`, painted at 720p.

{chr(10).join(_section(kind) for kind in KINDS.values())}"""


if __name__ == "__main__":
    sheet.take_no_options(__doc__)
    PAGE.write_text(text(), encoding="utf-8")
    sheet.save_all(PICTURES)
