"""A density map: how densely a layer lies at each place around the eye, as a text of a look file.

The text has 27 rows with spaces between them: those above the eye, from the brow down to the upper
lash line, then those below it. A row has one character for each of 24 places across, from the nose
outwards: "." is nothing, then follow 1 to 9, a to z, and A to Z, which is all of the product.
numpy is imported where it is used: help pages read the kinds, too, and need not wait for it.
"""

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from makeup_video.pipeline.errors import LookError
from makeup_video.pipeline.look.kinds.fields import EyePlaces
from makeup_video.pipeline.look.params import shown

if TYPE_CHECKING:
    import numpy as np

_LEVELS = ".123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
# The rows above the eye and below it: how many, and heights of the first and last, see EyePlaces.
_UP, _DOWN = (18, 2.1, 0.06), (9, -0.08, -1.3)
# How many places a row has, and `across` of the first and the last of them, see EyePlaces.
_ACROSS = (24, -0.4, 1.67)
HW = _UP[0] + _DOWN[0], _ACROSS[0]
_FADE = 0.35  # height over which a map fades out beyond its first and its last row


def heights(is_upper: bool) -> "np.ndarray":
    """The heights of the rows above the eye, (18,), or below it, (9,), float32; they fall."""
    import numpy as np

    count, first, last = _UP if is_upper else _DOWN
    return np.linspace(first, last, count, dtype=np.float32)


def places_across() -> "np.ndarray":
    """`across` of the places of a row, (24,) float32."""
    import numpy as np

    count, first, last = _ACROSS
    return np.linspace(first, last, count, dtype=np.float32)


def to_text(densities: "np.ndarray") -> str:
    """(27, 24), 0..1 -> the text."""
    import numpy as np

    levels = np.rint(np.clip(densities, 0, 1) * (len(_LEVELS) - 1)).astype(int)
    return " ".join("".join(_LEVELS[level] for level in row) for row in levels.tolist())


@lru_cache(maxsize=32)
def from_text(text: str) -> "np.ndarray":
    """The densities of a text, (27, 24) float32, 0..1; the array is read-only."""
    import numpy as np

    levels = [[_LEVELS.index(one) for one in row] for row in text.split(" ")]
    densities: np.ndarray = np.array(levels, np.float32) * np.float32(1 / (len(_LEVELS) - 1))
    densities.setflags(write=False)
    return densities


def check_text(text: Any, where: str) -> None:
    """Raises LookError for anything but a map's text or an empty text.

    where: the text's name in messages.
    """
    rows = text.split(" ") if isinstance(text, str) else [""]
    fits = len(rows) == HW[0] and all(len(row) == HW[1] for row in rows)
    if text != "" and not (fits and set("".join(rows)) <= set(_LEVELS)):
        raise LookError(
            f"{where} must be {HW[0]} rows of {HW[1]} characters . 1-9 a-z A-Z with spaces between "
            f"them, as a look that was read from a photo has them, or empty, got {shown(text)}"
        )


def density_at(at: EyePlaces, text: str) -> "np.ndarray":
    """How densely a layer lies at places around the eye, float32, 0..1: bilinear on the map."""
    import numpy as np

    rows, first = heights(at.is_upper), 0 if at.is_upper else _UP[0]
    found = from_text(text)[first : first + len(rows)]
    row = np.interp(-at.height, -rows, np.arange(len(rows)))
    columns = places_across()
    column = np.interp(at.across, columns, np.arange(len(columns)))
    y, x = np.broadcast_arrays(row.astype(np.float32), column.astype(np.float32))
    top, left = (np.minimum(v.astype(int), n - 2) for v, n in ((y, len(rows)), (x, len(columns))))
    down, right = y - top, x - left
    upper = found[top, left] + right * (found[top, left + 1] - found[top, left])
    lower = found[top + 1, left] + right * (found[top + 1, left + 1] - found[top + 1, left])
    beyond = at.height - rows[0] if at.is_upper else rows[-1] - at.height
    ends = np.clip(1 - beyond * np.float32(1 / _FADE), 0, 1)
    density: np.ndarray = ((upper + down * (lower - upper)) * ends).astype(np.float32)
    return density
