"""What a kind of makeup is given of a surface: where each of its places lies on the face.

Arrays are float32 and may be broadcast against each other to (N, H, W): the places on the grids of
N surfaces of one sort, such as both eyes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import numpy as np

LID_RISE_AT = 0.72  # across, where the lash line turns down to the outer corner
LID = 0.22  # height of a usual lid, in widths of the eye: the unit of heights below the eye


class LipsFields:
    """The lips.

    inward: 0 at their outer border, 1 where they meet or the mouth opens.
    """

    def __init__(self, measure: "Callable[[], np.ndarray]") -> None:
        """measure: makes `inward` at its first use; an even coat of lipstick does not need it."""
        self._measure = measure

    @cached_property
    def inward(self) -> "np.ndarray":
        return self._measure()


class EyePlaces(Protocol):
    """Places above both eyes, or below them, whatever the face: all that densities may depend on.

    across: 0 at the inner corner, 1 at the outer one, in widths of the eye.
    height: above the eye 0 at the upper lash line, 1 in the crease, 1.5 in the fold under the brow
    bone, 2 below the brow; below the eye 0 at the lower lash line and -1 a lid's usual height (LID)
    further down.
    is_upper: True for places above the eye.
    """

    @property
    def across(self) -> "np.ndarray": ...
    @property
    def height(self) -> "np.ndarray": ...
    @property
    def is_upper(self) -> bool: ...


@dataclass(frozen=True, slots=True, eq=False)
class EyeChart:
    """EyePlaces of no face in particular."""

    is_upper: bool
    across: "np.ndarray"
    height: "np.ndarray"


class EyeFields:
    """EyePlaces of a face, and the lengths that lines follow, in px of the frame.

    above_px: above the upper lash line, negative below it.  below_px: below the lower lash line,
    negative above it.  lid_rise_px: how far the upper lash line lies above the line through both
    corners of the eye at LID_RISE_AT.
    rise: how far each row of the grid lies above that line through the corners, in widths of the
    eye.  width_px: of the eye.
    """

    def __init__(
        self,
        is_upper: bool,
        across: "np.ndarray",
        rise: "np.ndarray",
        lids: "tuple[np.ndarray, np.ndarray, np.ndarray]",
        width_px: "np.ndarray",
        lid_rise: "Callable[[], np.ndarray]",
    ) -> None:
        """lids: the height above the eye, which may be below 0, above_px and below_px.
        lid_rise: makes the lid's rise, in widths of the eye."""
        self.is_upper, self.across, self.width_px = is_upper, across, width_px
        self._up, self.above_px, self.below_px = lids
        self.rise, self._lid_rise = rise, lid_rise

    @cached_property
    def height(self) -> "np.ndarray":
        import numpy as np

        if self.is_upper:
            height: np.ndarray = np.maximum(self._up, 0)
        else:
            height = np.minimum(self.below_px * (np.float32(-1 / LID) / self.width_px), 0)
        return height

    @property
    def lid_rise_px(self) -> "np.ndarray":
        rise: np.ndarray = self._lid_rise() * self.width_px
        return rise


@dataclass(frozen=True, slots=True, eq=False)
class FaceFields:
    """Coordinates on the mean face; the unit is the distance of the outer eye corners.

    across: from the middle of the face, negative on the picture's left.  down: from the line
    through the eye corners.
    """

    across: "np.ndarray"
    down: "np.ndarray"
