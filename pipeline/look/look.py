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
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar

from makeup_video.pipeline.errors import LookError
from makeup_video.pipeline.files.ordinary import read_ordinary
from makeup_video.pipeline.look.params import GraphicsParams, check_number, refuse_unknown, shown
from makeup_video.pipeline.look.regions import REGIONS

T = TypeVar("T")
_MOST_BYTES = 1_000_000  # a look has 1 kB
_MOST_DIGITS = 400  # no number in range has more, and Python reads no more than 4300


@dataclass(frozen=True, slots=True)
class Layer:
    """One product on one region.

    region: a key of REGIONS.  amount: how much of the product, 0 to 1.  shape: the region's dials
    by name.
    """

    region: str
    product: GraphicsParams
    amount: float
    shape: Mapping[str, Any]


def _with_regions(cls: type[T]) -> type[T]:
    """Adds a field for each region and dial of the registry that the class does not
    declare itself."""
    for info in REGIONS.values():
        for name, default in ((info.name, None), *((d.name, d.default) for d in info.dials)):
            if name not in cls.__annotations__:
                cls.__annotations__[name] = Any
                setattr(cls, name, default)
    return cls


@dataclass(frozen=True, slots=True)
@_with_regions
class Look:
    """Makeup: a product for each region (None: bare), the regions' dials, and the strength of all.

    strength scales all of it, 0..1. zone says where eye-shadow goes; intensity, 0..1, how much.
    """

    # declared for type checkers; regions that come later need no line here
    lips: GraphicsParams | None = None
    eyes: GraphicsParams | None = None
    strength: float = 1.0
    zone: str = "lid"
    intensity: float = 1.0

    VERSION: ClassVar[int] = 1

    def __post_init__(self) -> None:
        check_number("strength", self.strength, 0, 1)
        for info in REGIONS.values():
            for dial in info.dials:
                dial.check(getattr(self, dial.name))

    @property
    def products(self) -> dict[str, GraphicsParams]:
        """What is worn, by region, in the order in which it is painted; bare regions
        are left out."""
        worn = {name: getattr(self, name) for name in REGIONS}
        return {name: params for name, params in worn.items() if params is not None}

    @property
    def layers(self) -> list[Layer]:
        """What is painted, in order; nothing of which the amount is 0."""
        layers = []
        for name, params in self.products.items():
            dials = REGIONS[name].dials
            factors = [self.strength, *(getattr(self, d.name) for d in dials if d.scales)]
            if all(factors):
                shape = {dial.name: getattr(self, dial.name) for dial in dials}
                layers.append(Layer(name, params, math.prod(factors), shape))
        return layers

    @property
    def is_bare(self) -> bool:
        """True when nothing will be painted, so that every frame passes untouched."""
        return not self.layers

    @classmethod
    def from_dict(cls, values: Any) -> Self:
        """Read the parsed JSON. Raises LookError, one line naming the key and its range."""
        if not isinstance(values, dict):
            raise LookError(f"a look must be a JSON object, got {shown(values)}")
        refuse_unknown("the look", values, ("version", *(spec.name for spec in fields(cls))))
        version = values.get("version")
        if type(version) is not int or version != cls.VERSION:
            raise LookError(f"version must be {cls.VERSION}, got {shown(version)}")
        for info in REGIONS.values():
            if info.is_required and info.name not in values:
                raise LookError(f"{info.name} is missing: give an object, or null for none")
        settings = {name: value for name, value in values.items() if name != "version"}
        for name in REGIONS:
            if settings.get(name) is not None:
                settings[name] = GraphicsParams.from_dict(settings[name], name)
        return cls(**settings)

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
            raise LookError(f"{shown(key, repr)} is given twice: keep one")
        values[key] = value
    return values
