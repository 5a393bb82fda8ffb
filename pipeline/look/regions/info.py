"""What a region of makeup is to people: its names, its finishes, its dials. Data alone."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from makeup_video.pipeline.errors import LookError
from makeup_video.pipeline.look.params import check_number, shown

# Everything of GraphicsParams but the colour, in the order of a finish's row.
SETTINGS = (
    "opacity", "gloss", "gloss_roughness", "reflection",
    "edge_softness", "texture_keep", "undertone", "gloss_detail", "fresnel", "environment_blur",
    "shimmer", "shimmer_size", "shimmer_tint", "light_adaptation",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Dial:
    """A setting of its own that a region has: a key of the look file, and a field of Look.

    name: unlike that of any other dial.  title, meaning: what the page shows of it.
    choices: what it may be; without them it is a number in low..high.
    scales: the amount of the product is multiplied by this number.
    """

    name: str
    default: Any
    title: str
    meaning: str
    choices: tuple[str, ...] = ()
    low: float = 0.0
    high: float = 1.0
    scales: bool = False

    def check(self, value: Any) -> None:
        """Raises LookError for a value that the dial cannot have."""
        if not self.choices:
            check_number(self.name, value, self.low, self.high)
        elif value not in self.choices:
            raise LookError(
                f"{self.name} must be one of {', '.join(self.choices)}, got {shown(value)}"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class RegionInfo:
    """A region as people choose it.

    name: its key in look files, its field of Look, and the name of its file in render/regions.
    title: of its tab on the page.
    product: what is worn there.
    part: the part of a face that must be visible.
    category: a pattern for the words by which shops name such products, in lower case.
    first_rgb: the colour that the page begins with, sRGB code values 0..255.
    finishes: by the finish's name, a row of numbers in the order of SETTINGS.
    dials: the settings of its own.
    remark: what the documents say of the finishes.
    is_required: True when a look file must have its key, as before there were other regions.
    """

    name: str
    title: str
    product: str
    part: str
    category: str
    first_rgb: tuple[int, int, int]
    finishes: Mapping[str, tuple[float, ...]]
    dials: tuple[Dial, ...] = ()
    remark: str = ""
    is_required: bool = False

    def finish(self, name: str) -> dict[str, float]:
        """Every setting of GraphicsParams but red, green and blue."""
        return dict(zip(SETTINGS, self.finishes[name], strict=True))
