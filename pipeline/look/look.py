"""A look: what the makeup is, as a small JSON file that people read, edit, share and reuse.

    {"version": 1,
     "lips": {"red": 180, "green": 0, "blue": 46, "opacity": 0.8, "gloss": 0.6,
              "gloss_roughness": 0.4, "reflection": 0.2},
     "eyes": null,
     "strength": 1.0, "zone": "lid", "intensity": 1.0}

In a region, renderer settings may follow the seven parameters of the product; everything after
`eyes` may be left out. Reading is strict: a typo is an error, never a silently ignored key.
"""

import json
import sys
from collections.abc import Callable
from dataclasses import MISSING, asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar, Self

from makeup_video.pipeline.errors import LookError
from makeup_video.pipeline.ordinary import read_ordinary

ZONES = ("lid", "crease", "full", "outer")
_MOST_BYTES = 1_000_000  # a look has 1 kB
_MOST_DIGITS = 400  # no number in range has more, and Python reads no more than 4300
_UNBOUNDED = sys.float_info.max  # JSON can spell larger integers; kernels cannot


def _number(low: float, high: float, meaning: str, default: float | None = None) -> Any:
    """A dataclass field that carries its range and meaning; without a default it is required."""
    metadata = {"low": low, "high": high, "meaning": meaning}
    return (
        field(metadata=metadata) if default is None else field(default=default, metadata=metadata)
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class GraphicsParams:
    """The 17 rendering parameters of one region (the paper's g, section 3.1, then the renderer's).

    red, green, blue are sRGB-encoded code values 0..255, fractions allowed: the product's
    colour as under neutral light. Everything else has no unit.
    """

    red: float = _number(
        0, 255, "Red of the colour in the tube, as a colour picker shows it in neutral light."
    )
    green: float = _number(0, 255, "Green of the colour in the tube.")
    blue: float = _number(0, 255, "Blue of the colour in the tube.")
    opacity: float = _number(
        0, 1, "How much the product covers: 0 is bare skin, 1 hides the colour under it."
    )
    gloss: float = _number(
        0, _UNBOUNDED, "How wet it shines: 0 not at all, 1 a lip gloss, 4 lacquer."
    )
    gloss_roughness: float = _number(
        0, 1, "Size of the highlight: 0 a small sharp glint, 1 a broad soft sheen."
    )
    reflection: float = _number(0, 1, "How much of the room the product mirrors.")

    edge_softness: float = _number(
        0, 1, "How the border ends: 0 crisp, as after a liner, 1 blended out.", 0.5
    )
    texture_keep: float = _number(
        0, 1, "How much of the fine lines and folds is seen: 0 fills them, 1 keeps them all.", 0.5
    )
    undertone: float = _number(
        0, 1, "How much of the skin's own colour tints the product: 0 none, 1 all.", 0.0
    )
    gloss_detail: float = _number(
        0, 1, "Where it shines: 0 as a smooth surface would, 1 where the skin already does.", 0.5
    )
    fresnel: float = _number(
        0, 1, "How much more it mirrors where it turns away: 0 even all over, 1 at the rims.", 0.5
    )
    environment_blur: float = _number(
        0, 1, "How blurred the mirrored room is: 0 shapes can be told, 1 only light and dark.", 0.5
    )
    shimmer: float = _number(0, 1, "How many sparkles: 0 none, 1 as close as they come.", 0.0)
    shimmer_size: float = _number(0, 1, "Size of the sparkles: 0 fine dust, 1 coarse glitter.", 0.5)
    shimmer_tint: float = _number(
        0, 1, "Colour of the sparkles: 0 silver, 1 the product's own.", 0.5
    )
    light_adaptation: float = _number(
        0, 1, "How much of the light of the scene it takes on: 0 the same in any light, 1 all.", 1.0
    )

    def __post_init__(self) -> None:
        for spec in fields(self):
            value = getattr(self, spec.name)
            _check_number(spec.name, value, spec.metadata["low"], spec.metadata["high"])

    @property
    def is_worn(self) -> bool:
        """False when it changes nothing: neither opaque, nor glossy, nor reflecting."""
        return self.opacity > 0 or self.gloss > 0 or self.reflection > 0

    @property
    def hex(self) -> str:
        """The colour as "#B4002E"."""
        return "#" + bytes(round(code) for code in (self.red, self.green, self.blue)).hex().upper()

    @classmethod
    def from_dict(cls, values: Any, where: str = "region") -> Self:
        """Raises LookError that names the key, what it may be, and what came."""
        if not isinstance(values, dict):
            raise LookError(f"{where} must be an object or null, got {_shown(values)}")
        specs = {spec.name: spec for spec in fields(cls)}
        _refuse_unknown(where, values, specs)
        for name, spec in specs.items():
            if spec.default is MISSING and name not in values:
                text = _range_text(spec.metadata["low"], spec.metadata["high"])
                raise LookError(f"{where}.{name} is missing: give {text}")
        for name, value in values.items():
            metadata = specs[name].metadata
            _check_number(f"{where}.{name}", value, metadata["low"], metadata["high"])
        return cls(**values)


@dataclass(frozen=True, slots=True)
class Look:
    """Makeup for the lips and for the eyes (None: bare), and the user's own three dials.

    strength scales all of it, 0..1. zone says where eye-shadow goes; intensity, 0..1, how much.
    """

    lips: GraphicsParams | None = None
    eyes: GraphicsParams | None = None
    strength: float = 1.0
    zone: str = "lid"
    intensity: float = 1.0

    VERSION: ClassVar[int] = 1

    def __post_init__(self) -> None:
        _check_number("strength", self.strength, 0, 1)
        _check_number("intensity", self.intensity, 0, 1)
        if self.zone not in ZONES:
            raise LookError(f"zone must be one of {', '.join(ZONES)}, got {_shown(self.zone)}")

    @property
    def is_bare(self) -> bool:
        """True when nothing will be painted, so that every frame passes untouched."""
        return self.strength == 0 or (
            self.lips is None and (self.eyes is None or self.intensity == 0)
        )

    @classmethod
    def from_dict(cls, values: Any) -> Self:
        """Read the parsed JSON. Raises LookError, one line naming the key and its range."""
        if not isinstance(values, dict):
            raise LookError(f"a look must be a JSON object, got {_shown(values)}")
        known = ("version", "lips", "eyes", "strength", "zone", "intensity")
        _refuse_unknown("the look", values, known)
        version = values.get("version")
        if type(version) is not int or version != cls.VERSION:
            raise LookError(f"version must be {cls.VERSION}, got {_shown(version)}")
        for region in ("lips", "eyes"):
            if region not in values:
                raise LookError(f"{region} is missing: give an object, or null for none")
        regions: dict[str, Any] = {
            name: None if values[name] is None else GraphicsParams.from_dict(values[name], name)
            for name in ("lips", "eyes")
        }
        rest: dict[str, Any] = {
            name: values[name] for name in ("strength", "zone", "intensity") if name in values
        }
        return cls(**regions, **rest)

    def to_dict(self) -> dict[str, Any]:
        """The JSON object, all keys written out; `from_dict` gives the same look back."""
        return {"version": self.VERSION, **asdict(self)}

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a look file (UTF-8 JSON, at most 1 MB). Raises LookError naming file and fault."""
        try:
            text = read_ordinary(path, _MOST_BYTES).decode("utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "not UTF-8 text"
            raise LookError(f"{path}: a look file cannot be read: {reason}") from error
        try:
            values = json.loads(
                text, object_pairs_hook=_object_without_repeats, parse_int=whole_number
            )
            return cls.from_dict(values)
        except json.JSONDecodeError as error:
            raise LookError(
                f"{path}: not JSON at line {error.lineno}, column {error.colno}: {error.msg}"
            ) from error
        except RecursionError as error:
            raise LookError(f"{path}: a look is a flat JSON object, this nests too deep") from error
        except LookError as error:
            raise LookError(f"{path}: {error}") from None

    def save(self, path: str | Path) -> None:
        """Write the look as indented UTF-8 JSON."""
        Path(path).write_text(json.dumps(self.to_dict(), indent=2) + "\n", encoding="utf-8")


def whole_number(digits: str) -> int | float:
    """A whole number of JSON; infinite when it has more digits than any that may be given."""
    return int(digits) if len(digits) <= _MOST_DIGITS else float(digits)


def _object_without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for key, value in pairs:
        if key in values:
            raise LookError(f"{_shown(key, repr)} is given twice: keep one")
        values[key] = value
    return values


def _refuse_unknown(where: str, values: dict[str, Any], known: Any) -> None:
    for key in values:
        if key not in known:
            raise LookError(
                f"{where} has an unknown key {_shown(key, repr)}; known are {', '.join(known)}"
            )


def _check_number(name: str, value: Any, low: float, high: float) -> None:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not low <= value <= high:
        raise LookError(f"{name} must be {_range_text(low, high)}, got {_shown(value)}")


def _range_text(low: float, high: float) -> str:
    if high == _UNBOUNDED:
        return f"a finite number of at least {low:g}"
    return f"a number in {low:g}..{high:g}"


def _as_json(value: Any) -> str:
    return json.dumps(value, default=repr)


def _shown(value: Any, spell: Callable[[Any], str] = _as_json) -> str:
    """A value in one short line, as JSON writes it or as `spell` does."""
    try:
        text = spell(value)
    except (
        ValueError,
        TypeError,
        RecursionError,
    ):  # too many digits, keys that are no text, a circle
        text = f"something of type {type(value).__name__} that cannot be shown"
    return text if len(text) <= 60 else text[:57] + "..."
