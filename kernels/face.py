"""Host side of face.cl, which makes the surface of a whole face.

Its numpy twin is pipeline/render/surfaces/face_twin.py. The constants of both are here.
"""

from dataclasses import dataclass

import numpy as np
import pyopencl as cl
from makeup_video.kernels import colour
from makeup_video.kernels.definitions import Definitions, offsets
from makeup_video.kernels.light import (
    LIGHT_FIELDS,
    PLANE,
    LightPlanes,
    LightReader,
    light_numbers,
    on_planes,
)
from makeup_video.kernels.program import LOCAL_SIZE, Device
from makeup_video.kernels.surface import FAINT, GridPlace

# The grid is a square of 1.6 IOD (the distance of the outer eye corners) around
# `fit_points`: from ear to ear, and from above the brows to the upper half of the chin.
SIDE = 40
STEP = 1.6 / (SIDE - 1)  # IOD
# Sigma of the broad light in px of the grid: as wide as on lids, where an eye is 0.31 IOD wide.
SIGMA_PX = 0.65

# The drawn masks reach this many px of the grid beyond it, as far as the blurs of their borders do.
MARGIN = 4
EDGE_PX, HOLE_PX = 1.3, 0.6  # sigma of the borders of the outline and of holes, px of the grid
# What the blurred mask, 0 to 255, has on the outline: OpenCV's smooth polygons are two thirds of a
# px too large on each side.
ON_EDGE = 179.0
HOLE_GAIN = 1.5  # holes are small: a blur makes them shallow

# Where a face may be seen: its visibility rises from 0 at the first number to 1 at the second.
FACING = 0.12, 0.35  # z of the normal
HIGHEST = -0.42, -0.30  # `down`
LOWEST = 1.0, 0.85  # `down` at the chin
SAMPLED = 0.5  # `visible` from which a node is a sample of the skin
# The cheeks, whose mean light is the surface's mean: ranges of |across| and of `down`, in IOD.
CHEEK_ACROSS, CHEEK_DOWN = (0.2, 0.65), (0.1, 0.55)

# The fit of the surface to points; all lengths are in IOD.
POINTS, FRONT_POINTS = 60, 14  # all points used, and those that may hide others
DEGREE = 3
SIGMA = 0.14  # of the Gaussians
NOISE = 0.1  # variance of a point's place, relative to the Gaussians' variance; more is smoother
FARTHEST = -20.0  # least exponent of a Gaussian; products of smaller ones get denormal and slow
CUBIC = 3.0  # variance of the cubic's coefficients: they are nearly free
POINT_FACING = 0.1, 0.5  # z of a point's normal from which the point counts, and counts fully
LEAST = 1e-4  # least weight of a point, so that every fit has a solution
# A point is hidden by another one that is nearer to the viewer (the share rises from 0 to 1 between
# the two distances), close in the picture (sigma CLOSE), and far off on the mean face (`may_hide`).
NEARER = 0.07, 0.14
CLOSE = 0.08
HIDES = 1.5  # factor of that share: a point that is hidden by two thirds does not count
MOST_OFF = 3.0  # IOD: coordinates of points are clipped to it, so that all numbers stay finite

# Likeness to the skin. Ranges of `down` of three parts of a face that are seldom covered together:
# forehead, beside the bridge of the nose, cheeks. The fit begins with the part most like skin,
# which is redder and lighter (hair, sunglasses and masks are less red, and most are darker).
PARTS = (-0.42, -0.12), (-0.02, 0.28), (0.28, 0.62)
BESIDE = 0.55  # most |across| of these parts, in IOD
FEWEST = 6  # samples that a part, or a face, must have
# Weight and most of a part's log luminance above the usual one, then of its log red to green.
LIGHTER, MOST_LIGHTER = 0.5, 0.3
REDDER, MOST_RED = 2.0, 0.8
DARK = 0.06  # share of the skin's luminance; what is darker is noise, its colour does not count
LEAST_LIGHT = 1e-6  # keeps logarithms finite
# Expected standard deviations of skin: log luminance, log red to green, log blue to green.
SPREAD = 0.40, 0.22, 0.22
EXPECTED = 0.2  # weight of SPREAD beside the measured deviations
# Ridges that keep the fitted planes from sloping, across and down. Colour hardly changes down a
# face, but it changes at the upper edge of a mask, which the planes must not follow.
LEVEL_RIDGE, LIGHT_RIDGE, COLOUR_RIDGE = 1e-3, (40.0, 40.0), (100.0, 2000.0)
FAR = 4.0  # squared deviation from the start at which a sample counts a quarter
BRIGHTER = 0.5  # weight of being lighter: skin shines, and few things beside it are lighter
SHINE_PALES = 0.3  # how much less red, and more blue, per log luminance that skin is lighter
# Skin that is paler by more than that is rare, but masks and screens are. This much of log red to
# blue counts as one more standard deviation.
PALER = 0.2
SKIN, OTHER = 2.6, 4.0  # deviations: up to the first, all is skin; from the second on, nothing
MIDDLE = 0.3  # the planes count `down` from here

_PADDED = -(-POINTS // 8) * 8  # points in whole eights
_SAMPLES = SIDE * SIDE // 4 + 8  # every second node of every second row, and eight more
_TERMS = (DEGREE + 1) * (DEGREE + 2) // 2
_DRAWN = SIDE + 2 * MARGIN
_PAD = 8  # beyond each end of a blurred row

# The buffers of face.cl, all of float32.
TABLES = np.dtype([
    ("tangents", np.float32, (2, POINTS, _PADDED)),
    ("mean_xy", np.float32, (2, _PADDED)),
    ("front", np.float32, FRONT_POINTS),
    ("may_hide", np.float32, (FRONT_POINTS, _PADDED)),
])  # fmt: skip
GIVEN = np.dtype([
    ("to_luma", np.float32, (2, 3)),  # px of the grid -> px of the plane
    ("to_chroma", np.float32, (2, 3)),
    *LIGHT_FIELDS,
    ("to_srgb", np.float32, (3, 3)),  # linear light in the frame's primaries -> in sRGB's
    ("to_frame", np.float32, (2, 3)),  # px of the grid -> px of the frame
    ("frame_wh", np.float32, 2),
    ("sampled_down", np.float32),  # the skin is sampled above this `down`
    ("points", np.float32, (3, _PADDED)),  # x, y, z in IOD from the middle of the grid
    ("inside", np.float32, (_DRAWN, _DRAWN)),
    ("holes", np.float32, (_DRAWN, _DRAWN)),
])  # fmt: skip
OUT = np.dtype([
    ("across", np.float32, (SIDE, SIDE)),
    ("down", np.float32, (SIDE, SIDE)),
    ("normals", np.float32, (2, SIDE, SIDE)),
    ("facing", np.float32, (SIDE, SIDE)),
    ("visible", np.float32, (SIDE, SIDE)),
    ("likeness", np.float32, (SIDE, SIDE)),
    ("shading", np.float32, (SIDE, SIDE)),
    ("mean", np.float32),
])  # fmt: skip
SCRATCH = np.dtype([
    ("normal", np.float32, (3, _PADDED)),
    ("noise", np.float32, _PADDED),
    ("terms", np.float32, (_TERMS, _PADDED)),
    ("system", np.float32, (POINTS, _PADDED + 8)),  # a row's last eight: its right-hand sides
    ("near_x", np.float32, (POINTS, SIDE)),
    ("near_y", np.float32, (POINTS, SIDE)),
    ("cubic", np.float32, (_TERMS, 8)),
    ("borders", np.float32, (2, _DRAWN, SIDE)),  # of the outline and of holes
    ("light", np.float32, (4, SIDE, SIDE)),  # luminance, and red, green, blue of sRGB
    ("sample", np.float32, (6, _SAMPLES)),  # the same, across, `down`
    ("numbers", np.float32, (3, _SAMPLES)),
    ("part", np.float32, (3, _SAMPLES)),
    ("skin", np.float32, 32),
    ("layers", np.float32, (2, SIDE, SIDE)),
    ("blurred", np.float32, (2, SIDE, SIDE + 2 * _PAD)),
    ("total", np.float32),
])  # fmt: skip

DEFINITIONS = colour.DEFINITIONS + Definitions(
    {
        "SIDE": SIDE,
        "STEP": STEP,
        "DRAWN": _DRAWN,
        "MARGIN": MARGIN,
        "ON_EDGE": ON_EDGE,
        "IN_HOLE": 255 / HOLE_GAIN,
        "FACING_FROM": FACING[0],
        "FACING_TO": FACING[1],
        "HIGHEST_FROM": HIGHEST[0],
        "HIGHEST_TO": HIGHEST[1],
        "LOWEST_FROM": LOWEST[0],
        "LOWEST_TO": LOWEST[1],
        "SAMPLED": SAMPLED,
        "CHEEK_INNER": CHEEK_ACROSS[0],
        "CHEEK_OUTER": CHEEK_ACROSS[1],
        "CHEEK_TOP": CHEEK_DOWN[0],
        "CHEEK_BOTTOM": CHEEK_DOWN[1],
        "POINTS": POINTS,
        "PADDED": _PADDED,
        "FRONT_POINTS": FRONT_POINTS,
        "DEGREE": DEGREE,
        "TERMS": _TERMS,
        "PER_SIGMA": -0.5 / SIGMA**2,
        "NOISE": NOISE,
        "FARTHEST": FARTHEST,
        "CUBIC": CUBIC,
        "POINT_FACING_FROM": POINT_FACING[0],
        "POINT_FACING_TO": POINT_FACING[1],
        "LEAST": LEAST,
        "NEARER_FROM": NEARER[0],
        "NEARER_TO": NEARER[1],
        "PER_CLOSE": -0.5 / CLOSE**2,
        "HIDES": HIDES,
        "SAMPLES": _SAMPLES,
        "FIRST_PART_FROM": PARTS[0][0] - MIDDLE,
        "FIRST_PART_TO": PARTS[0][1] - MIDDLE,
        "SECOND_PART_FROM": PARTS[1][0] - MIDDLE,
        "SECOND_PART_TO": PARTS[1][1] - MIDDLE,
        "THIRD_PART_FROM": PARTS[2][0] - MIDDLE,
        "THIRD_PART_TO": PARTS[2][1] - MIDDLE,
        "BESIDE": BESIDE,
        "FEWEST": FEWEST,
        "LIGHTER": LIGHTER,
        "MOST_LIGHTER": MOST_LIGHTER,
        "REDDER": REDDER,
        "MOST_RED": MOST_RED,
        "DARK": DARK,
        "LEAST_LIGHT": LEAST_LIGHT,
        "SPREAD_LIGHT": SPREAD[0],
        "SPREAD_RED": SPREAD[1],
        "SPREAD_BLUE": SPREAD[2],
        "EXPECTED": EXPECTED,
        "LEVEL_RIDGE": LEVEL_RIDGE,
        "LIGHT_ACROSS_RIDGE": LIGHT_RIDGE[0],
        "LIGHT_DOWN_RIDGE": LIGHT_RIDGE[1],
        "COLOUR_ACROSS_RIDGE": COLOUR_RIDGE[0],
        "COLOUR_DOWN_RIDGE": COLOUR_RIDGE[1],
        "FAR": FAR,
        "BRIGHTER": BRIGHTER,
        "SHINE_PALES": SHINE_PALES,
        "PALER": PALER,
        "SKIN": SKIN,
        "OTHER": OTHER,
        "MIDDLE": MIDDLE,
        "FAINT": FAINT,
        "PAD": _PAD,
    }
    | offsets(PLANE)
    | offsets(TABLES)
    | offsets(GIVEN)
    | offsets(OUT)
    | offsets(SCRATCH)
)
_GIVEN_AT = offsets(GIVEN)
_HEAD_SIZE = _GIVEN_AT["POINTS_AT"]


@dataclass(frozen=True, slots=True, eq=False)
class FitTables:
    """What the fit of every face shares, float32.

    mean_xy: (POINTS, 2), the points on the mean face, in IOD.
    to_tangents: (2 POINTS, POINTS), from points to the derivatives along x, then y, of the mean
    face.
    front: (FRONT_POINTS,) indices of the points that may hide others.
    may_hide: (POINTS, FRONT_POINTS), 0 for neighbours, 1 for points far from each other.
    """

    mean_xy: np.ndarray
    to_tangents: np.ndarray
    front: np.ndarray
    may_hide: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class FaceToRead:
    """A face, as the kernel takes it.

    points: (POINTS, 3) float32 in IOD, turned upright, from the middle of the grid; z away from the
    viewer.
    inside, holes: (48, 48) uint8, 0 to 255, on the grid and MARGIN px around it: what lies within
    the outline of the face, and which parts of that are not skin.
    place: of the grid.  frame_wh: px.  sampled_down: the skin is sampled above this `down`.
    """

    points: np.ndarray
    inside: np.ndarray
    holes: np.ndarray
    place: GridPlace
    frame_wh: tuple[int, int]
    sampled_down: float


class FaceKernel:
    """Runs the kernel for one face at a time, on a device that no other thread uses.

    Its memory is kept, so that the kernel keeps its arguments.
    """

    def __init__(self, device: Device, tables: FitTables) -> None:
        self._device = device
        self._light = LightReader(device)
        filled = np.zeros((), TABLES)
        for axis, tangents in enumerate(np.split(tables.to_tangents, 2)):
            filled["tangents"][axis, :, :POINTS] = tangents.T
        filled["mean_xy"][:, :POINTS] = tables.mean_xy.T
        filled["front"] = tables.front
        filled["may_hide"][:, :POINTS] = tables.may_hide.T
        self._tables = self._light.kept(filled)
        self._given, self._out = device.memory((1,), GIVEN), device.memory((1,), OUT)
        self._given.array.fill(0)
        self._numbers = self._given.array.view(np.float32)
        self._scratch = cl.Buffer(device.context, cl.mem_flags.READ_WRITE, SCRATCH.itemsize)

    def __call__(self, face: FaceToRead, light: LightPlanes) -> np.void:
        """Make the surface of a face: a record of OUT, see FaceSurface.

        `shading` is the broad light on the grid, and `mean` the mean light of the cheeks.
        """
        self._fill(face, light)
        kernel = self._light.kernel(
            "face", DEFINITIONS, light, (self._given.buffer, self._tables),
            (self._scratch, self._out.buffer),
        )  # fmt: skip
        self._given.send()
        self._device.launch(kernel, (LOCAL_SIZE[0], 1))
        self._out.fetch()
        self._device.finish()
        made: np.void
        (made,) = self._out.array.view(np.float32).copy().view(OUT)  # quicker than a record's copy
        return made

    def _fill(self, face: FaceToRead, light: LightPlanes) -> None:
        to_px = face.place.to_px
        self._numbers[:_HEAD_SIZE] = [
            *on_planes(to_px, light),
            *light_numbers(light),
            *colour.to_srgb_primaries(light.coding.primaries).ravel().tolist(),
            *to_px, *face.frame_wh, face.sampled_down,
        ]  # fmt: skip
        (given,) = self._given.array
        np.clip(face.points.T, -MOST_OFF, MOST_OFF, out=given["points"][:, :POINTS])
        given["inside"], given["holes"] = face.inside, face.holes
