"""Look files and catalogues, as people write them."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

_LIPS: dict[str, Any] = {
    "red": 180, "green": 0, "blue": 46, "opacity": 0.8, "gloss": 0.6, "gloss_roughness": 0.4,
    "reflection": 0.2,
}  # fmt: skip
_RENDERER: dict[str, Any] = {
    "edge_softness": 0.4, "texture_keep": 1, "undertone": 0.1, "gloss_detail": 0.0,
    "fresnel": 0.5, "environment_blur": 0.2, "shimmer": 0.7, "shimmer_size": 0.3,
    "shimmer_tint": 0.9, "light_adaptation": 1.0,
}  # fmt: skip
_LOOKS: dict[str, dict[str, Any]] = {
    "lips.json": {"version": 1, "lips": _LIPS, "eyes": None},
    "both.json": {
        "version": 1, "lips": {**_LIPS, **_RENDERER}, "eyes": {**_LIPS, "blue": 200.5},
        "strength": 0.7, "zone": "crease", "intensity": 0.5,
    },
    "bare.json": {"version": 1, "lips": None, "eyes": None, "strength": 1.0},
    "layers.json": {
        "version": 2, "strength": 0.9,
        "layers": [
            {"kind": "lipstick", "product": _LIPS,
             "shape": {"gradient": 0.4, "rim": 0.5, "rim_color": "#5A1A1E"}},
            {"kind": "eyeliner", "product": _LIPS, "shape": {"thickness": 0.2, "wing": 0.3}},
            {"kind": "eyeshadow", "product": {**_LIPS, **_RENDERER}, "strength": 0.6,
             "shape": {"slot": "crease", "low": -0.5}},
            {"kind": "eyeshadow", "product": _LIPS},
            {"kind": "blush", "product": _LIPS, "shape": {"height": 0.3, "softness": 0.9}},
        ],
    },
}  # fmt: skip
_COMMAS = (
    "brand,product,shade,hex,price\n"
    'Brand,"Velvet, matte",Cherry,#AF052D,12\n'
    "Other,Gloss,Été,B4002E,9\n"
    'Third,"with ""quotes""",Rose,#e9c,\n'
)
_SEMICOLONS = "\ufeffHex;Brand;Product;Shade\r\n#112233;A;B;C\r\n;;;\r\nabc;D;E;F\r\n"


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="")


WRITERS: dict[str, Callable[[Path], None]] = {
    **{name: partial(_write, text=json.dumps(v, indent=1)) for name, v in _LOOKS.items()},
    "commas.csv": partial(_write, text=_COMMAS),
    "semicolons.csv": partial(_write, text=_SEMICOLONS),
}
