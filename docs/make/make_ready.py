"""Write docs/ready.md and its pictures. The script keeps the text under the heading JUDGEMENT.

python docs/make/make_ready.py
"""

from collections.abc import Callable

import contact_sheet as sheet
import numpy as np
from makeup_video.pipeline import Look
from makeup_video.pipeline.look.ready import ready_looks

PAGE = sheet.DOCS / "ready.md"
JUDGEMENT = "## What looks wrong"
_FACE_WH, _CELL_WH, _IN_ROW = (190, 210), (190, 120), 5
_EYE_LOOKS = ("cat-eye", "glam", "smoky-black", "sunset", "festival-blue")
_THREE_LIGHTS = ("light x 0.5", "warm", "cool")
_FACES = {"hopper": sheet.portrait, "astronaut": sheet.astronaut}
_EYES = {"open": 0, "shut": 24}  # frames of samples/in.mp4


def draw_ready(face: str) -> np.ndarray:
    """Draw every ready look on a face, in rows of five."""
    scene, looks = _FACES[face](), {"bare": Look(), **_ready()}
    cells = [scene.closeup(look, sheet.FACE, _FACE_WH) for look in looks.values()]
    names = list(looks)
    blank = np.full_like(cells[0], 255)
    rows = []
    for at in range(0, len(cells), _IN_ROW):
        row = cells[at : at + _IN_ROW]
        row += [blank] * (_IN_ROW - len(row))
        labels = names[at : at + _IN_ROW] + [""] * (_IN_ROW - len(names[at : at + _IN_ROW]))
        rows.append(sheet.grid([row], labels))
    return np.vstack(rows)


def draw_ready_eyes() -> np.ndarray:
    """Draw the looks that differ most around the eyes, on several eyes."""
    scenes = {name: sheet.clip(at) for name, at in _EYES.items()}
    scenes |= {"glasses": sheet.portrait(), "smile": sheet.astronaut()}
    return sheet.draw_looks(scenes, _eye_looks(), sheet.EYE, _CELL_WH)


def draw_ready_lights() -> np.ndarray:
    """Draw some looks in three lights."""
    scenes = {light: sheet.astronaut().in_light(light) for light in _THREE_LIGHTS}
    return sheet.draw_looks(scenes, _eye_looks(), sheet.FACE, _FACE_WH)


def _ready() -> dict[str, Look]:
    return {one.name: one.look for one in ready_looks()}


def _eye_looks() -> dict[str, Look]:
    ready = _ready()
    return {name: ready[name] for name in _EYE_LOOKS}


PICTURES: dict[str, Callable[[], np.ndarray]] = {
    "looks-hopper.jpg": lambda: draw_ready("hopper"),
    "looks-astronaut.jpg": lambda: draw_ready("astronaut"),
    "looks-eyes.jpg": draw_ready_eyes,
    "looks-lights.jpg": draw_ready_lights,
}


def text() -> str:
    """Return the page down to the heading JUDGEMENT."""
    rows = [[f"`{one.name}`", one.words] for one in ready_looks()]
    return f"""# Ready looks

<!-- Written by docs/make/make_ready.py (extra: samples), down to the last heading. -->

Nothing is retouched. How to use and edit the looks: [looks.md](looks.md#ready-looks).

{sheet.table(["look", "what it is"], rows)}

On both portraits of the samples:

{sheet.picture("looks-hopper")}

{sheet.picture("looks-astronaut")}

Eyes, open and shut (frames of `samples/in.mp4`), behind glasses on older lids, and in a smile:

{sheet.picture("looks-eyes")}

In half the light, in warm and in cool light:

{sheet.picture("looks-lights")}

{JUDGEMENT}
"""


def kept_judgement() -> str:
    """Return the text of the present page under the heading JUDGEMENT, or ""."""
    return sheet.kept_after(PAGE, JUDGEMENT)


if __name__ == "__main__":
    sheet.take_no_options(__doc__)
    PAGE.write_text(text() + kept_judgement(), encoding="utf-8")
    sheet.save_all(PICTURES)
