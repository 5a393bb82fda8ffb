"""Host side of surface.cl, with the constants and buffer layouts that it shares with its twins.

The numpy twins are pipeline/render/surfaces/lips_twin.py, eyes_twin.py and
pipeline/render/luminance_twin.py.
"""

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyopencl as cl
from makeup_video.kernels import colour
from makeup_video.kernels.definitions import Definitions, floats, offsets
from makeup_video.kernels.light import (
    LIGHT_FIELDS,
    PLANE,
    Affine,
    LightPlanes,
    LightReader,
    light_numbers,
    on_planes,
)
from makeup_video.kernels.program import LOCAL_SIZE, Device

# Rows and columns of the patch of the lips, of the lips' grid, and of a lid's grid.
PATCH_HW, LIPS_HW, LID_HW = (80, 112), (40, 56), (32, 48)
RING_POINTS = 11  # of half a ring of the lips, from corner to corner
LASH_POINTS, BROW_POINTS = 9, 5  # of a curve around the eye; of the brow's lower edge
LID_CURVES = 5  # of each eye: lash line, crease, fold, brow, lower lash line
_POINTS, _REGIONS = 478, 3

# The lips: where between border (0) and opening (1) the slopes between the mesh's rings hold.
BETWEEN = (0.19, 0.57, 0.88)
# Lips are fuller than the mesh: (upper, lower), added to the slope at the border, and how much the
# addition changes on the way to the opening.
FULLER, FULLER_CHANGE = (-0.30, 0.45), (0.75, -1.0)
STEEPEST = 2.5
# How far beyond the contours the mask is trusted, in widths of the mouth: out over the skin, and
# into the opening, whose contour lies on bare lip where a mouth is round.
REACH, OPENING_REACH = 0.06, 0.15
LIMIT_STEEPNESS = 2.5  # log-odds per px beyond that reach
# Where the mask is unsure, the contours count: with this share, up to this many px. Both draw the
# border a little too tight, so WIDER is added to the log-odds.
CONTOUR_SHARE, CONTOUR_MOST = 0.25, 4.8
WIDER = 0.25
RIM_START = 0.8  # twice the share of the way from border to opening at which the rim begins
# CORNER_MORE is added to the log-odds at the corners of an open mouth, because the net mostly
# misses lips about as narrow as its px. It grows from CORNER_FROM to CORNER_TO of the way from the
# middle to a corner, and counts fully where the middle opens by OPENED widths of the mouth.
CORNER_MORE, CORNER_FROM, CORNER_TO, OPENED = 1.0, 0.5, 0.9, 0.12
# Subtracted from the log-odds of the lower lip of a shut mouth, away from the corners: the net
# takes some of the shade below the lip for lip.
LOWER_LESS = 0.75
# How far the edge is pushed over the line where shut lips meet, and onto the lips where the mouth
# is open, as shares of half the edge. On photos, 3 % of the lips' area is then painted between the
# lips.
OVER_SEAM, ONTO_LIP = 0.3, 0.5

# The lids: first column and step of the grid, in widths of the eye.
LID_LEFT, LID_STEP = -0.92, 2.17 / 47
# The hair of a brow ends this far below the mesh's lower edge of the brow. It is the median over
# labelled photos: 0.08 above the middle of the eye, 0.03 at both ends.
LID_BROW_BELOW = 0.06 / LID_STEP
LID_FOLD_UP = 1.5  # the fold lies half-way from the crease (1) to the brow (2), on average
# The mesh's rings close at the corners of the eye, where their heights would collapse. So from the
# columns LID_SEEDS on, the crease comes down to the lash line, and the fold to the crease, by at
# most LID_FALLS rows per column, on the inner and the outer side. They stay LID_LEAST rows apart.
LID_SEEDS = tuple(round((out - LID_LEFT) / LID_STEP) for out in (-0.41, 0.42))
LID_FALLS = (0.45, 0.25)
LID_LEAST = 0.05 / LID_STEP
LID_FOLD_LEAST = 0.25  # least height of the fold, as a share of the way from the crease to the brow
# The grid's unit is the eye's width. Where an eye is turned away or a brow is raised, curves would
# lie beyond the grid's first row. So each curve's row is held to at least a share of the row of the
# curve below it. The first row's heights are then at least LID_HIGHEST, where the softest shadow up
# to the brow ends.
LID_HIGHEST = 2.6
LID_HELD = 0.5  # the share for crease and fold; the brow's follows from LID_HIGHEST
LID_BROW_HELD = 1 - (2 - LID_FOLD_UP) / (LID_HIGHEST - LID_FOLD_UP)
# Beyond the corners the lash lines go on in their direction, and settle within LID_SETTLE columns.
LID_CORNERS = tuple((out - LID_LEFT) / LID_STEP for out in (-0.5, 0.5))
LID_SETTLE = 0.04 / LID_STEP
LID_STEEPEST = 2.0
# Columns from and to which normals follow the mesh, whose curves end a little beyond the corners.
LID_TURNS = tuple(round((out - LID_LEFT) / LID_STEP) for out in (-0.5, 0.56))
# The mesh's lids face down, and so does the skin up to the brow; but a lid lies on a ball. So
# LID_LEAN is subtracted from the slope above the eye, and LID_ROUNDNESS times the height below the
# lid's middle is added, so lashes face down and the crease up. That goes on to the height
# LID_ROUND_TO: if skin above faced the light again, it would have a second highlight. Skin below
# the lower lash line does not lie on the ball: there LID_BELOW alone is added, whatever the lids
# do.
LID_LEAN, LID_ROUNDNESS, LID_ROUND_TO, LID_BELOW = 0.6, 1.0, 1.5, 0.4
# Where a lid's light is averaged: from and to which height (lash line 0, crease 1), and how far
# from the middle, in widths of the eye.
LID_LIGHT_FROM, LID_LIGHT_TO, LID_LIGHT_BESIDE = 0.15, 1.25, 0.55

# The columns that light is read for, first and end, in eights: all columns of the area above.
LID_LIT = (
    int((-LID_LIGHT_BESIDE - LID_LEFT) / LID_STEP) // 8,
    int((LID_LIGHT_BESIDE - LID_LEFT) / LID_STEP) // 8 + 1,
)

# Sigmas in px of the grid: of the blur of light within an area, and of the blur of the lips'
# normals.
LIPS_SIGMA_PX, LID_SIGMA_PX, SEAM_SIGMA_PX = 3.0, 1.8, 0.8
# Where the lips meet there is a furrow without highlights, although the normals between a lip that
# faces down and one that faces up face the viewer. Beside the furrow, highlights grow from 1.5 to 5
# px of the patch.
FURROW_PER_PX = 1 / 3.5
FURROW = 1.5 * FURROW_PER_PX
FAINT = 0.02  # weight of the mean light in the blurs, which counts far from an area
LEAST_SQUARE = 1e-6  # least squared length, so that nothing divides by zero

# The buffers of surface.cl, all of float32. A point of the frame lies at
# to_own (point - near) + origin in a region's own px; `near` is a whole px close to the region, so
# that the difference is exact in float32.
PLACE = np.dtype([
    ("to_own", np.float32, (2, 2)),
    ("near", np.float32, 2),
    ("origin", np.float32, 2),
    ("own_px", np.float32),  # px of the region for one px of the frame
    ("step_px", np.float32),  # px of the frame for one px of the region
    ("to_luma", np.float32, (2, 3)),  # px of the grid -> px of the plane
    ("to_chroma", np.float32, (2, 3)),
])  # fmt: skip
GIVEN = np.dtype([
    ("places", PLACE, _REGIONS),
    *LIGHT_FIELDS,
    ("points", np.float32, (_POINTS, 3)),
    ("logits", np.float32, PATCH_HW),
])  # fmt: skip
OUT = np.dtype([
    ("odds", np.float32, PATCH_HW),
    ("rim", np.float32, PATCH_HW),
    ("lips", np.float32, (5, *LIPS_HW)),  # shading, x and y of the normal, exposed, upper
    ("lids", np.float32, (2, 6, *LID_HW)),  # each: up, lash_px, `lips`' first three, below_px
    ("means", np.float32, _REGIONS),
])  # fmt: skip
# The scratch memory of a region. A row of numbers by column is as long as the patch is wide. A
# blurred row has _PAD more on each side, filled by mirroring without repeating the last value.
_PAD = 16
_COLUMNS = PATCH_HW[1]
SCRATCH = np.dtype([
    ("curves", np.float32, (24, _COLUMNS)),  # height and depth of each curve
    ("corners", np.float32, 16),  # x of both corners of the mouth; y of the opening, in the middle
    # The straight parts of the border of the upper and of the lower lip: x and y where one begins,
    # x and y from there to where it ends, 1 / its length squared, and x per y along it.
    ("border", np.float32, (2, RING_POINTS - 1, 6)),
    ("bends", np.float32, (10, _COLUMNS)),
    ("columns", np.float32, (28, _COLUMNS)),
    ("light", np.float32, LIPS_HW),
    ("layers", np.float32, (6, *LIPS_HW)),
    ("blurred", np.float32, (6, LIPS_HW[0], LIPS_HW[1] + 2 * _PAD)),
])  # fmt: skip

DEFINITIONS = colour.DEFINITIONS + Definitions(
    {
        "PATCH_HIGH": PATCH_HW[0],
        "PATCH_WIDE": PATCH_HW[1],
        "LIPS_HIGH": LIPS_HW[0],
        "LIPS_WIDE": LIPS_HW[1],
        "LID_HIGH": LID_HW[0],
        "LID_WIDE": LID_HW[1],
        "RING": RING_POINTS,
        "LASHES": LASH_POINTS,
        "BROWS": BROW_POINTS,
        "LID_CURVES": LID_CURVES,
        "FIRST_BETWEEN": BETWEEN[0],
        "MIDDLE_BETWEEN": BETWEEN[1],
        "LAST_BETWEEN": BETWEEN[2],
        "FULLER_UPPER": FULLER[0],
        "FULLER_LOWER": FULLER[1],
        "FULLER_UPPER_CHANGE": FULLER_CHANGE[0],
        "FULLER_LOWER_CHANGE": FULLER_CHANGE[1],
        "STEEPEST": STEEPEST,
        "REACH": REACH,
        "OPENING_REACH": OPENING_REACH,
        "LIMIT_STEEPNESS": LIMIT_STEEPNESS,
        "CONTOUR_SHARE": CONTOUR_SHARE,
        "CONTOUR_MOST": CONTOUR_MOST,
        "WIDER": WIDER,
        "CORNER_MORE": CORNER_MORE,
        "CORNER_FROM": CORNER_FROM,
        "CORNER_TO": CORNER_TO,
        "OPENED": OPENED,
        "LOWER_LESS": LOWER_LESS,
        "RIM_START": RIM_START,
        "OVER_SEAM": OVER_SEAM,
        "FURROW_PER_PX": FURROW_PER_PX,
        "FURROW": FURROW,
        "ONTO_LIP": ONTO_LIP,
        "LID_LEFT": LID_LEFT,
        "LID_STEP": LID_STEP,
        "LID_STEEPEST": LID_STEEPEST,
        "LID_TURN_FROM": LID_TURNS[0],
        "LID_TURN_TO": LID_TURNS[1],
        "LID_BROW_BELOW": LID_BROW_BELOW,
        "LID_FOLD_UP": LID_FOLD_UP,
        "LID_INNER_SEED": LID_SEEDS[0],
        "LID_OUTER_SEED": LID_SEEDS[1],
        "LID_INNER_FALL": LID_FALLS[0],
        "LID_OUTER_FALL": LID_FALLS[1],
        "LID_LEAST": LID_LEAST,
        "LID_FOLD_LEAST": LID_FOLD_LEAST,
        "LID_HELD": LID_HELD,
        "LID_BROW_HELD": LID_BROW_HELD,
        "LID_INNER_CORNER": LID_CORNERS[0],
        "LID_OUTER_CORNER": LID_CORNERS[1],
        "LID_SETTLE": LID_SETTLE,
        "LID_LEAN": LID_LEAN,
        "LID_ROUNDNESS": LID_ROUNDNESS,
        "LID_ROUND_TO": LID_ROUND_TO,
        "LID_BELOW": LID_BELOW,
        "LID_LIGHT_FROM": LID_LIGHT_FROM,
        "LID_LIGHT_TO": LID_LIGHT_TO,
        "LID_LIGHT_BESIDE": LID_LIGHT_BESIDE,
        "LID_LIT_FROM": LID_LIT[0],
        "LID_LIT_TO": LID_LIT[1],
        "FAINT": FAINT,
        "PAD": _PAD,
        "PLACE_SIZE": floats(PLACE),
        "SCRATCH_SIZE": floats(SCRATCH),
        "LEAST_SQUARE": LEAST_SQUARE,
        "BORDER_PART": SCRATCH["border"].shape[-1],
        "BORDER_PARTS": math.prod(SCRATCH["border"].shape[1:]),
    }
    | offsets(PLACE)
    | offsets(PLANE)
    | offsets(GIVEN)
    | offsets(OUT)
    | offsets(SCRATCH)
)

_GIVEN_AT = offsets(GIVEN)
_HEAD_SIZE = _GIVEN_AT["POINTS_AT"]  # of `given`: three places, and the light
_NOWHERE = (0.0,) * floats(PLACE)  # a place without a region


@dataclass(frozen=True, slots=True)
class GridPlace:
    """Where a grid lies on the frame, and the space in which its region is measured.

    to_px: px of the grid -> px of the frame.  own_to_px: the region's own px -> px of the frame.
    """

    to_px: Affine
    own_to_px: Affine


@dataclass(frozen=True, slots=True, eq=False)
class FaceSurfaces:
    """The surfaces of one face, float32. A region without a place holds undefined values.

    odds, rim: (80, 112), see LipsSurface.
    lips: (5, 40, 56), shading, x and y of the normals, exposed, upper.
    lids: (2, 6, 32, 48), for each lid up, lash_px (see LidSurface), shading, x and y of normals,
    below_px.
    means: mean light of the lips and of both lids.
    """

    odds: np.ndarray
    rim: np.ndarray
    lips: np.ndarray
    lids: np.ndarray
    means: list[float]


class SurfaceKernel:
    """Runs the kernel for one face at a time; threads wait for each other."""

    def __init__(self, device: Device, rings: np.ndarray) -> None:
        """rings: (18, RING_POINTS), the points of each curve, see surface.cl."""
        self._device = device
        self._lock = threading.Lock()
        self._light = LightReader(device)
        self._rings = self._light.kept(rings.astype(np.int32))
        self._memory = device.memory((floats(GIVEN),), np.float32)
        self._given = self._memory.array
        self._given.fill(0)
        self._out = device.memory((1,), OUT)
        scratch_bytes = _REGIONS * SCRATCH.itemsize
        self._scratch = cl.Buffer(device.context, cl.mem_flags.READ_WRITE, scratch_bytes)

    def __call__(
        self,
        places: Sequence[GridPlace | None],
        points_px: np.ndarray,
        logits: np.ndarray,
        light: LightPlanes,
    ) -> FaceSurfaces:
        """Make the surfaces of a face.

        places: of the lips and of both eyes.  points_px: (478, 3).  logits: (80, 112) of lipstick.
        """
        with self._lock:
            self._fill(places, points_px, logits, light)
            made = self._run(light)
        return FaceSurfaces(
            made["odds"], made["rim"], made["lips"], made["lids"], made["means"].tolist()
        )

    def _fill(
        self,
        places: Sequence[GridPlace | None],
        points_px: np.ndarray,
        logits: np.ndarray,
        light: LightPlanes,
    ) -> None:
        numbers: list[float] = []
        for place in places:
            numbers += _place(place, light) if place else _NOWHERE
        self._given[:_HEAD_SIZE] = numbers + light_numbers(light)
        logits_at = _GIVEN_AT["LOGITS_AT"]
        self._given[_HEAD_SIZE:logits_at] = points_px.ravel()
        if places[0]:
            self._given[logits_at:] = logits.ravel()

    def _run(self, light: LightPlanes) -> np.void:
        """A record of OUT."""
        kernel = self._light.kernel(
            "surface", DEFINITIONS, light, (self._memory.buffer, self._rings),
            (self._scratch, self._out.buffer),
        )  # fmt: skip
        self._memory.send()
        self._device.launch(kernel, (_REGIONS * LOCAL_SIZE[0], 1))
        self._out.fetch()
        self._device.finish()
        made: np.void
        (made,) = self._out.array.view(np.float32).copy().view(OUT)  # quicker than a record's copy
        return made


def _place(place: GridPlace, light: LightPlanes) -> Sequence[float]:
    """Return the numbers of a PLACE."""
    a, b, left, c, d, top = place.own_to_px
    size = a * d - b * c
    if not 0 < abs(size) < math.inf:
        return _NOWHERE
    step = math.sqrt(abs(size))
    # the whole px of the frame from which points are counted
    x, y = float(round(left)), float(round(top))
    right, down = x - left, y - top
    numbers = [d / size, -b / size, -c / size, a / size, x, y]
    numbers += [(d * right - b * down) / size, (a * down - c * right) / size, 1 / step, step]
    return numbers + on_planes(place.to_px, light)
