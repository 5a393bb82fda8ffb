"""The 17 parameters of one product, with range and meaning; strict reading of numbers and hex
colours."""

import json
import re
import sys
from collections.abc import Callable, Iterable
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, Self

from makeup_video.pipeline.errors import LookError
from makeup_video.pipeline.look.unchangeable import unchangeable

_HEX = re.compile(r"#?([0-9a-fA-F]{3}|[0-9a-fA-F]{6})")


def rgb_of_hex(text: str) -> tuple[int, int, int] | None:
    """Red, green, blue, 0..255, from '#B4002E', 'B4002E' or '#B02'; None for what is no colour."""
    if not _HEX.fullmatch(text):
        return None
    digits = text.removeprefix("#")
    if len(digits) == 3:
        digits = "".join(2 * digit for digit in digits)
    red, green, blue = bytes.fromhex(digits)
    return red, green, blue


def hex_of(rgb: Iterable[float]) -> str:
    """Red, green, blue, 0..255, as "#B4002E"; fractions are rounded."""
    return "#" + bytes(round(code) for code in rgb).hex().upper()


_UNBOUNDED = sys.float_info.max  # JSON can spell larger integers; kernels cannot


def _number(low: float, high: float, meaning: str, default: float | None = None) -> Any:
    """A dataclass field that carries its range and meaning; without a default it is required."""
    metadata = {"low": low, "high": high, "meaning": meaning}
    return (
        field(metadata=metadata) if default is None else field(default=default, metadata=metadata)
    )


@unchangeable("dataclasses.replace makes another")
@dataclass(frozen=True, slots=True, kw_only=True)
class GraphicsParams:
    """The 17 rendering parameters of one product (the paper's g, section 3.1, then the renderer's).

    red, green, blue are sRGB-encoded code values 0..255, fractions allowed: the product's colour in
    neutral light. All other parameters have no unit.
    """

    red: float = _number(
        0, 255, "Red of the product's own colour, as a colour picker shows it in neutral light."
    )
    green: float = _number(0, 255, "Green of the product's own colour.")
    blue: float = _number(0, 255, "Blue of the product's own colour.")
    opacity: float = _number(
        0, 1, "How much the product covers: 0 is transparent, 1 hides the colour of the skin."
    )
    gloss: float = _number(
        0,
        _UNBOUNDED,
        "How strongly the product shines: 0 not at all, 1 like lip gloss, 4 like lacquer.",
    )
    gloss_roughness: float = _number(
        0, 1, "Size of the highlights: 0 is a small sharp glint, 1 a broad soft sheen."
    )
    reflection: float = _number(0, 1, "How strongly the product mirrors its surroundings.")

    edge_softness: float = _number(
        0, 1, "How soft the border is: 0 is crisp, as drawn with a pencil, 1 is blended out.", 0.5
    )
    texture_keep: float = _number(
        0, 1, "How visible fine lines and folds stay: 0 fills them, 1 keeps them all.", 0.5
    )
    undertone: float = _number(
        0, 1, "How much the skin's own colour tints the product: 0 not at all, 1 fully.", 0.0
    )
    gloss_detail: float = _number(
        0,
        1,
        "Where the product shines: 0 as a smooth surface would, 1 where the skin already shines.",
        0.5,
    )
    fresnel: float = _number(
        0,
        1,
        "How much stronger reflections are at grazing angles: 0 is even all over, 1 strongest at "
        "the edges.",
        0.5,
    )
    environment_blur: float = _number(
        0,
        1,
        "How blurred the mirrored surroundings are: 0 shows shapes, 1 only light and dark.",
        0.5,
    )
    shimmer: float = _number(
        0, 1, "How many sparkles there are: 0 none, 1 as dense as possible.", 0.0
    )
    shimmer_size: float = _number(
        0, 1, "Size of the sparkles: 0 is fine dust, 1 coarse glitter.", 0.5
    )
    shimmer_tint: float = _number(
        0, 1, "Colour of the sparkles: 0 is silver, 1 the product's own colour.", 0.5
    )
    light_adaptation: float = _number(
        0,
        1,
        "How much the product follows the light of the scene: 0 looks the same in any light, "
        "1 follows it fully.",
        1.0,
    )

    def __post_init__(self) -> None:
        for spec in fields(self):
            value = as_python(getattr(self, spec.name))
            check_number(spec.name, value, spec.metadata["low"], spec.metadata["high"])
            object.__setattr__(self, spec.name, value)

    @property
    def is_worn(self) -> bool:
        """False for a product that changes nothing: neither opaque, nor glossy, nor reflecting."""
        return self.opacity > 0 or self.gloss > 0 or self.reflection > 0

    @property
    def hex(self) -> str:
        """The colour as "#B4002E"."""
        return hex_of((self.red, self.green, self.blue))

    @classmethod
    def from_dict(cls, values: Any, where: str = "product") -> Self:
        """A product from its parameters by name; `color`, as "#B4002E", may stand for the first
        three. Raises LookError that names the key, its range, and the value given."""
        if not isinstance(values, dict):
            raise LookError(f"{where} must be an object, got {shown(values)}")
        specs = {spec.name: spec for spec in fields(cls)}
        refuse_unknown(where, values, (*specs, "color"))
        if "color" in values:
            values = _with_rgb(values, where)
        for name, spec in specs.items():
            if spec.default is MISSING and name not in values:
                text = _range_text(spec.metadata["low"], spec.metadata["high"])
                raise LookError(f"{where}.{name} is missing: give {text}")
        for name, value in values.items():
            metadata = specs[name].metadata
            check_number(f"{where}.{name}", value, metadata["low"], metadata["high"])
        return cls(**values)


def _with_rgb(values: dict[str, Any], where: str) -> dict[str, Any]:
    """The parameters of a product with red, green and blue in place of its `color`."""
    rest = dict(values)
    colour = rest.pop("color")
    rgb = rgb_of_hex(colour) if isinstance(colour, str) else None
    if rgb is None:
        raise LookError(f"{where}.color must be a colour such as '#B4002E', got {shown(colour)}")
    names = ("red", "green", "blue")
    if twice := [name for name in names if name in rest]:
        raise LookError(f"{where} has color and {twice[0]}: leave one of them out")
    return dict(zip(names, rgb, strict=True)) | rest


def refuse_unknown(where: str, values: dict[str, Any], known: Any) -> None:
    for key in values:
        if key not in known:
            raise LookError(
                f"{where} has an unknown key {shown(key, repr)}; known are {', '.join(known)}"
            )


def as_python(value: Any) -> Any:
    """A number of numpy as a number of Python, the only kind that JSON takes; else the value."""
    return value.item() if getattr(value, "shape", None) == () else value


def check_number(name: str, value: Any, low: float, high: float) -> None:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not low <= value <= high:
        raise LookError(f"{name} must be {_range_text(low, high)}, got {shown(value)}")


def _range_text(low: float, high: float) -> str:
    if high == _UNBOUNDED:
        return f"a finite number of at least {low:g}"
    return f"a number in {low:g}..{high:g}"


def _as_json(value: Any) -> str:
    """JSON that keeps letters such as umlauts, and also escapes characters that do not print."""
    text = json.dumps(value, default=repr, ensure_ascii=False)
    return "".join(one if one.isprintable() else json.dumps(one)[1:-1] for one in text)


def shown(value: Any, spell: Callable[[Any], str] = _as_json) -> str:
    """A value in one short line, as JSON writes it or as `spell` does."""
    try:
        text = spell(value)
    except (ValueError, TypeError, RecursionError):
        # too many digits, keys that are not text, or an object that contains itself
        text = f"something of type {type(value).__name__} that cannot be shown"
    return text if len(text) <= 60 else text[:57] + "..."
