"""A look: what the makeup is, as a list of layers, each a product of a kind in a place.

    {"version": 2, "strength": 1.0,
     "layers": [
       {"kind": "lipstick",
        "product": {"red": 180, "green": 0, "blue": 46, "opacity": 0.8, "gloss": 0.6,
                    "gloss_roughness": 0.4, "reflection": 0.2}},
       {"kind": "eyeshadow", "strength": 0.8,
        "product": {"red": 90, "green": 58, "blue": 46, "opacity": 0.7, "gloss": 0,
                    "gloss_roughness": 0.9, "reflection": 0},
        "shape": {"slot": "outer", "softness": 0.6}}]}

Ten optional parameters of a product may follow the seven required ones. `strength`, `shape` and
each parameter of a shape may be left out. Files of version 1 have one product for `lips` and one
for `eyes`. Reading is strict: a typo is an error.
"""

import errno
import os
import stat
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar, NoReturn, Self

from makeup_video.pipeline.errors import LookError, OutputError
from makeup_video.pipeline.files.disk_errors import unreadable, unwritable
from makeup_video.pipeline.files.ordinary import read_ordinary
from makeup_video.pipeline.files.path_argument import check_path
from makeup_video.pipeline.look.kinds import KINDS, PAINTED
from makeup_video.pipeline.look.kinds.kind import LEFT_EYE, RIGHT_EYE, Kind
from makeup_video.pipeline.look.params import (
    GraphicsParams,
    as_python,
    check_number,
    refuse_unknown,
    shown,
)
from makeup_video.pipeline.look.strict_json import read_json, written
from makeup_video.pipeline.look.unchangeable import unchangeable

_MOST_BYTES = 1_000_000  # a look has 2 to 6 kB
_ORDER = {name: place for place, name in enumerate(PAINTED)}
_NO_NAME = "the name of the look file is empty: give one"
_KEYS = ("kind", "strength", "product", "shape")


class _Fixed(dict[str, Any]):
    """A dict that nobody can change. Unlike MappingProxyType it can be pickled, copied and written
    as JSON."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        advice = "dataclasses.replace(layer, shape=...) makes another layer"
        raise TypeError(f"the shape of a layer cannot be changed: {advice}")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)


@unchangeable("dataclasses.replace makes another")
@dataclass(frozen=True, slots=True)
class Layer:
    """A product of one kind.

    kind: a key of KINDS.  shape: values of some of the kind's dials, kept as a read-only copy; the
    other dials have the values of the zone (`slot`), or their defaults.  strength: how much of the
    product, 0 to 1.  Raises LookError for an unknown kind, and for a value out of range.
    """

    kind: str
    product: GraphicsParams
    shape: Mapping[str, Any] = field(default_factory=dict)
    strength: float = 1.0

    def __post_init__(self) -> None:
        kind = _kind(self.kind, "kind")
        if not isinstance(self.product, GraphicsParams):
            raise TypeError(
                f"the product of a layer must be GraphicsParams, got "
                f"{type(self.product).__name__}: product('#B4002E', 'gloss', {kind.part!r}) makes "
                "them"
            )
        shape, strength = self.shape, as_python(self.strength)
        if isinstance(shape, Mapping):
            # a read-only copy: the caller may change its own mapping
            shape = _Fixed({name: as_python(value) for name, value in shape.items()})
        kind.check_shape(shape, "shape")
        check_number("strength", strength, 0, 1)
        object.__setattr__(self, "shape", shape)
        object.__setattr__(self, "strength", strength)

    def __hash__(self) -> int:
        return hash((self.kind, self.product, tuple(sorted(self.shape.items())), self.strength))

    @property
    def whole_shape(self) -> dict[str, Any]:
        """A value for every dial of the kind."""
        return KINDS[self.kind].whole_shape(self.shape)

    @classmethod
    def from_dict(cls, values: Any, where: str = "layer") -> Self:
        """A layer from its JSON object. Raises LookError naming key, range and given value."""
        if not isinstance(values, dict):
            raise LookError(f"{where} must be an object, got {shown(values)}")
        refuse_unknown(where, values, _KEYS)
        for key in ("kind", "product"):
            if key not in values:
                raise LookError(f"{where}.{key} is missing: {_GIVE[key]}")
        kind = _kind(values["kind"], f"{where}.kind")
        shape, strength = values.get("shape", {}), values.get("strength", 1.0)
        kind.check_shape(shape, f"{where}.shape")
        check_number(f"{where}.strength", strength, 0, 1)
        product = GraphicsParams.from_dict(values["product"], f"{where}.product")
        return cls(kind.name, product, shape, strength)

    def to_dict(self) -> dict[str, Any]:
        """The JSON object with all keys; the shape has only the dials that were given."""
        return {
            "kind": self.kind,
            "strength": self.strength,
            "product": asdict(self.product),
            "shape": dict(self.shape),
        }


_GIVE = {
    "kind": f"give one of {', '.join(KINDS)}",
    "product": "give an object",
    "version": "give 2",
    "layers": "give a list",
}


@unchangeable("with_kind and dataclasses.replace make another")
@dataclass(frozen=True, slots=True, init=False)
class Look:
    """Makeup: layers in the order of painting, and the strength of all, 0..1.

    layers are sorted into the order of painting; layers of one kind keep their order. lips and eyes
    are the short way to one lipstick and one eyeshadow: zone is the eyeshadow's slot, intensity its
    strength.  Raises LookError for a number out of range and for too many layers of a kind.
    """

    layers: tuple[Layer, ...]
    strength: float

    VERSION: ClassVar[int] = 2

    def __init__(
        self,
        layers: Iterable[Layer] = (),
        strength: float = 1.0,
        *,
        lips: GraphicsParams | None = None,
        eyes: GraphicsParams | None = None,
        zone: str = "lid",
        intensity: float = 1.0,
    ) -> None:
        strength, intensity = as_python(strength), as_python(intensity)
        check_number("strength", strength, 0, 1)
        check_number("intensity", intensity, 0, 1)
        (slot,) = (dial for dial in KINDS["eyeshadow"].dials if dial.name == "slot")
        slot.check(zone, "zone")
        given = _several(layers)
        for layer in given:
            if not isinstance(layer, Layer):
                raise TypeError(f"a look's layers must be Layer, got {type(layer).__name__}")
        if eyes is None and (zone != ZONES[0] or intensity != 1):
            raise LookError("zone and intensity belong to eyeshadow: give eyes, too")
        if eyes is not None:
            given.append(Layer("eyeshadow", eyes, {"slot": zone}, intensity))
        if lips is not None:
            given.append(Layer("lipstick", lips))
        check_count([(layer.kind, layer.shape) for layer in given])
        given.sort(key=lambda layer: _ORDER[layer.kind])
        object.__setattr__(self, "layers", tuple(given))
        object.__setattr__(self, "strength", strength)

    @property
    def lips(self) -> GraphicsParams | None:
        """The lipstick; None on bare lips."""
        return self._first("lipstick")

    @property
    def eyes(self) -> GraphicsParams | None:
        """The first eyeshadow; None on bare lids."""
        return self._first("eyeshadow")

    @property
    def zone(self) -> str:
        """The zone of the first eyeshadow."""
        return next((layer.whole_shape["slot"] for layer in self.of("eyeshadow")), ZONES[0])

    def _first(self, kind: str) -> GraphicsParams | None:
        return next((layer.product for layer in self.of(kind)), None)

    def of(self, kind: str) -> tuple[Layer, ...]:
        """The layers of one kind, in the order of painting. Raises LookError for another word."""
        _kind(kind, "kind")
        return tuple(layer for layer in self.layers if layer.kind == kind)

    def with_kind(self, kind: str, layers: Iterable[Layer]) -> Self:
        """The same look with other layers of one kind; an empty `layers` takes the kind off.

        Raises LookError for a word that is no kind, or a layer of another kind.
        """
        _kind(kind, "kind")
        layers = _several(layers)
        for layer in layers:
            if isinstance(layer, Layer) and layer.kind != kind:
                raise LookError(f"layers must be of the kind {kind}, got one of {layer.kind}")
        others = [layer for layer in self.layers if layer.kind != kind]
        return replace(self, layers=(*others, *layers))

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds that are worn, in the order of KINDS."""
        worn = {layer.kind for layer in self.layers}
        return tuple(name for name in KINDS if name in worn)

    @property
    def painted(self) -> list[Layer]:
        """The layers that change anything, in the order of painting. Each has a value for every
        dial, and its strength is multiplied by that of the look."""
        return [
            replace(layer, shape=layer.whole_shape, strength=layer.strength * self.strength)
            for layer in self.layers
            if layer.strength * self.strength > 0 and layer.product.is_worn
        ]

    @property
    def is_bare(self) -> bool:
        """True without layers or strength, so that every frame passes untouched, unread.

        A look whose products have no effect is not bare: its user is told why nothing is painted.
        """
        return not any(layer.strength * self.strength > 0 for layer in self.layers)

    @classmethod
    def from_dict(cls, values: Any) -> Self:
        """Read the parsed JSON. Raises LookError, one line naming the key and its range."""
        if not isinstance(values, dict):
            raise LookError(f"a look must be a JSON object, got {shown(values)}")
        if "version" not in values:
            raise LookError(f"version is missing: {_GIVE['version']}")
        version = values["version"]
        if type(version) is not int or version not in (1, cls.VERSION):
            raise LookError(f"version must be 1 or {cls.VERSION}, got {shown(version)}")
        if version == 1:
            return cls(**_from_version_1(values))
        refuse_unknown("the look", values, ("version", "strength", "layers"))
        if "layers" not in values:
            raise LookError(f"layers is missing: {_GIVE['layers']}")
        layers = values["layers"]
        if not isinstance(layers, list):
            raise LookError(f"layers must be a list, got {shown(layers)}")
        check_count(
            [(one.get("kind"), one.get("shape")) for one in layers if isinstance(one, dict)]
        )
        read = [Layer.from_dict(one, f"layers[{at}]") for at, one in enumerate(layers)]
        return cls(read, values.get("strength", 1.0))

    def to_dict(self) -> dict[str, Any]:
        """The JSON object with all keys; `from_dict` gives the same look back."""
        layers = [layer.to_dict() for layer in self.layers]
        return {"version": self.VERSION, "strength": self.strength, "layers": layers}

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a look file (UTF-8 JSON, at most 1 MB). Raises LookError naming file and fault."""
        if not check_path("path", path):
            raise LookError(_NO_NAME)
        try:
            text = read_ordinary(path, _MOST_BYTES).decode("utf-8-sig")
        except OSError as error:
            raise LookError(unreadable(path, error, " as a look file")) from error
        except UnicodeDecodeError as error:
            raise LookError(f"{path} cannot be read as a look file: not UTF-8 text") from error
        try:
            return cls.from_dict(read_json(text))
        except LookError as error:
            raise LookError(f"{path}: {error}") from None

    def save(self, path: str | Path) -> None:
        """Write the look as indented UTF-8 JSON.

        Raises OutputError. A file that was there before is then unchanged, unless its folder takes
        no new files.
        """
        if not check_path("path", path):
            raise OutputError(_NO_NAME)
        try:
            self._write(Path(path))
        except OSError as error:
            raise OutputError(unwritable(path, error, "choose another place")) from error
        except ValueError as error:  # a NUL in the name
            raise OutputError(
                f"{path} cannot be written: no file has such a name; choose another"
            ) from error

    def _write(self, path: Path) -> None:
        text, target = written(self.to_dict()), Path(os.path.realpath(path))
        if target.is_symlink():  # links that lead to each other
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
        part = target.with_name(f".{target.name}-{os.urandom(4).hex()}")
        is_there, folder = target.exists(), target.parent
        if is_there and not (target.is_file() and os.access(folder, os.W_OK)):
            target.write_text(text, encoding="utf-8")  # such as /dev/stdout
            return
        if is_there and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        try:
            part.write_text(text, encoding="utf-8")
            if is_there:
                os.chmod(part, stat.S_IMODE(target.stat().st_mode))
            os.replace(part, target)
        except BaseException:
            part.unlink(missing_ok=True)
            raise


def _several(layers: Iterable[Layer]) -> list[Layer]:
    if not isinstance(layers, Iterable):
        raise TypeError(
            f"layers must be a list of Layer, got {type(layers).__name__}: put layers in []"
        )
    return list(layers)


def check_look(look: object) -> None:
    """Raises TypeError for anything but a Look; the message says how to make one."""
    if isinstance(look, Look):
        return
    how = "Look(lips=product('#B4002E', 'gloss')) makes one"
    if isinstance(look, Mapping):
        how = "Look.from_dict(...) makes one of the object of a look file"
    elif isinstance(look, str | Path):
        how = "Look.load('look.json') reads a file, ready_look('cat-eye').look is a ready one"
    elif hasattr(look, "look"):
        how = "give its attribute look"
    raise TypeError(f"a look must be a Look, got {type(look).__name__}: {how}")


def check_count(layers: list[tuple[Any, Any]]) -> None:
    """Raises LookError for more layers of a kind than a look may have.

    layers: the kind and the shape of each, which need not be valid.
    """
    for kind in KINDS.values():
        count, where = most_in_a_place([shape for name, shape in layers if name == kind.name])
        if count > kind.most:
            what = "layer" if kind.most == 1 else "layers"
            raise LookError(
                f"a look has at most {kind.most} {what} of {kind.name}, got {count}{where}"
            )


def most_in_a_place(shapes: list[Any]) -> tuple[int, str]:
    """The number of layers of a kind on the eye with most of them, and " on the left eye" or the
    like. Where no layer is for one eye only: the number of all layers, and "".

    shapes: the shapes of the layers, which need not be valid.
    """
    eyes = [shape.get("eye") if isinstance(shape, Mapping) else None for shape in shapes]
    left, right = eyes.count(LEFT_EYE), eyes.count(RIGHT_EYE)
    eye = LEFT_EYE if left > right else RIGHT_EYE
    return len(eyes) - min(left, right), f" on the {eye} eye" if left or right else ""


def _kind(name: Any, where: str) -> Kind:
    if not isinstance(name, str) or name not in KINDS:
        raise LookError(f"{where} must be one of {', '.join(KINDS)}, got {shown(name)}")
    return KINDS[name]


def _from_version_1(values: dict[str, Any]) -> dict[str, Any]:
    """The arguments of Look from the JSON object of a look file of version 1."""
    keys = ("version", "lips", "eyes", "strength", "zone", "intensity")
    refuse_unknown("the look", values, keys)
    for name in ("lips", "eyes"):
        if name not in values:
            raise LookError(f"{name} is missing: give an object, or null for none")
    zone = values.get("zone", "lid")
    if not isinstance(zone, str) or zone not in ZONES:
        raise LookError(f"zone must be one of {', '.join(ZONES)}, got {shown(zone)}")
    arguments = {name: value for name, value in values.items() if name != "version"}
    check_number("intensity", arguments.get("intensity", 1.0), 0, 1)
    if arguments["eyes"] is None:
        arguments.pop("zone", None)
        arguments.pop("intensity", None)
    for name in ("lips", "eyes"):
        if arguments[name] is not None:
            arguments[name] = GraphicsParams.from_dict(arguments[name], name)
    return arguments


ZONES = ("lid", "crease", "full", "outer")  # of version 1
