"""What a kind of makeup is: its names, its finishes, its shape, and where on a face it lies."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from makeup_video.pipeline.errors import LookError
from makeup_video.pipeline.look.kinds.density_map import check_text
from makeup_video.pipeline.look.params import GraphicsParams, check_number, refuse_unknown, shown

if TYPE_CHECKING:
    import numpy as np

# Everything of GraphicsParams but the colour, in the order of a finish's row.
SETTINGS = (
    "opacity", "gloss", "gloss_roughness", "reflection",
    "edge_softness", "texture_keep", "undertone", "gloss_detail", "fresnel", "environment_blur",
    "shimmer", "shimmer_size", "shimmer_tint", "light_adaptation",
)  # fmt: skip
_GLOSSY = 0.4  # gloss of satin, from which on a product is no longer matte
Shape = Mapping[str, Any]  # values of a kind's dials by name, none missing
# The choices of the dial `eye`: which of the wearer's eyes wear a layer.
BOTH_EYES, LEFT_EYE, RIGHT_EYE = "both", "left", "right"


@dataclass(frozen=True, slots=True)
class Dial:
    """One parameter of a kind's shape: a number, a choice, a colour or a map.

    title, meaning: its texts on the page and in the documents.
    unit: of a number; empty for a share.
    choices: the values that it may have; without them it is a number in low..high, a colour, or a
    map.
    is_colour: True for a text such as "#B4002E".
    is_map: True for a text as in density_map.py, or an empty text.
    """

    name: str
    default: Any
    title: str
    meaning: str
    choices: tuple[str, ...] = ()
    low: float = 0.0
    high: float = 1.0
    unit: str = ""
    is_colour: bool = False
    is_map: bool = False

    def check(self, value: Any, where: str) -> None:
        """Raises LookError for a value that the dial cannot have; where: its name in messages."""
        if self.choices:
            if value not in self.choices:
                raise LookError(
                    f"{where} must be one of {', '.join(self.choices)}, got {shown(value)}"
                )
        elif self.is_colour:
            if not isinstance(value, str) or not re.fullmatch("#[0-9a-fA-F]{6}", value):
                raise LookError(f"{where} must be a colour such as '#B4002E', got {shown(value)}")
        elif self.is_map:
            check_text(value, where)
        else:
            check_number(where, value, self.low, self.high)


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A line between two borders, sharp at any size of the frame.

    above: how far each place of the grid lies above the lower border, px of the frame.
    below: how far it lies below the upper border.  Both are positive within the line, and their sum
    is its thickness; float32, (N, H, W).
    """

    above: "np.ndarray"
    below: "np.ndarray"


@dataclass(frozen=True, slots=True, eq=False)
class Coat:
    """A product on a surface of the face.

    density: share of the product at each place of the grid, float32, 0..1, (N, H, W); None for 1
    everywhere.
    strokes: lines that are drawn in place of a density; where several meet, the densest counts.
    blur_px: over how many px of the frame their borders fade.
    """

    product: GraphicsParams
    density: "np.ndarray | None" = None
    strokes: tuple[Stroke, ...] = ()
    blur_px: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A kind of makeup.

    name: its name in look files.
    part: its name where people choose parts of a look, and the command's option for it.
    title, product: the names of its tab on the page, and of what is worn.
    words, slot_words: other words for the part, and for its slots, that people type.
    must_see: the part of a face that must be seen.
    category: a pattern for the words by which shops name such products, in lower case; empty where
    a photo of products is no guide.
    first_rgb: the colour that the page begins with, sRGB code values 0..255.
    finishes: for each finish, by name, a row of numbers in the order of SETTINGS.
    first_finish: the finish of a colour that is given without one.
    dials: the parameters of its shape.
    slots: named shapes, each some values of the dials; the dial `slot` chooses one.
    is_read: True when it is read from photos.
    follows_color: True when a colour for a look, given without parts, changes this kind.
    remark: what the documents say of the finishes.
    shown: the shape with which the documents show what each of its numbers does.
    most: how many layers of this kind a look may have; with the dial `eye`, how many on each eye.
    order: kinds with smaller numbers are painted first.
    region: where on a face it is painted, a key of REGIONS in render/regions.
    coats: makes the coats of a layer, in the order of painting, from the fields of a surface of
    that region. Densities are drawn once for a look, whatever the face; strokes for every frame.
    is_line: True for a kind whose only coat is drawn with strokes.
    spared: pixels darker than this share of the broad light around them stay bare (lashes, the dark
    of a mouth), unless the product is darker still.
    keep_highlights: share of the skin's own highlights that lie over the product: 1 for a film of
    lipstick, little for a powder.
    keep_matte: the share of keep_highlights that a product without gloss has.
    """

    name: str
    part: str
    title: str
    product: str
    words: tuple[str, ...] = ()
    slot_words: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    must_see: str
    category: str
    first_rgb: tuple[int, int, int]
    finishes: Mapping[str, tuple[float, ...]]
    first_finish: str = "satin"
    dials: tuple[Dial, ...] = ()
    slots: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    is_read: bool = False
    follows_color: bool = False
    remark: str = ""
    shown: Mapping[str, Any] = field(default_factory=dict)
    most: int = 1
    order: int
    region: str
    coats: Callable[[Any, GraphicsParams, Shape], list[Coat]]
    is_line: bool = False
    spared: float = 0.0
    keep_highlights: float = 1.0
    keep_matte: float = 1.0

    @property
    def has_eyes(self) -> bool:
        """Whether a layer may lie on one eye alone."""
        return any(dial.name == "eye" for dial in self.dials)

    def finish(self, name: str) -> dict[str, float]:
        """Every setting of GraphicsParams but red, green and blue."""
        return dict(zip(SETTINGS, self.finishes[name], strict=True))

    def kept_highlights(self, product: GraphicsParams) -> float:
        """The share of the skin's own highlights that lies over a product, 0..1."""
        share = min(product.gloss / _GLOSSY, 1)
        return self.keep_highlights * (self.keep_matte + (1 - self.keep_matte) * share)

    def check_shape(self, shape: Any, where: str) -> None:
        """Raises LookError for anything but an object of the kind's dials."""
        if not isinstance(shape, Mapping):
            raise LookError(f"{where} must be an object, got {shown(shape)}")
        dials = {dial.name: dial for dial in self.dials}
        refuse_unknown(where, dict(shape), dials)
        for name, value in shape.items():
            dials[name].check(value, f"{where}.{name}")

    def whole_shape(self, shape: Shape) -> dict[str, Any]:
        """A shape with a value for every dial: those given, then those of its slot, then the
        defaults."""
        defaults = {dial.name: dial.default for dial in self.dials}
        slot = shape.get("slot", defaults.get("slot"))
        return defaults | dict(self.slots.get(slot, {})) | dict(shape)
