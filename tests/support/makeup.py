"""Arbitrary products, lights and surfaces; faces with known true points; the painter."""

import sys
from dataclasses import fields, replace
from functools import cache
from itertools import groupby

import av
import cv2
import heads
import numpy as np
from hypothesis import strategies as st
from makeup_video.kernels.colour import HLG, LUMA_WEIGHTS, PQ, SRGB, Coding
from makeup_video.kernels.material import ENVIRONMENT_PX
from makeup_video.kernels.material_twin import Environment, Material
from makeup_video.kernels.paint import Canvas
from makeup_video.kernels.paint_twin import PaintedRegion
from makeup_video.kernels.planes import Rect
from makeup_video.kernels.program import Device
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.faces.topology import LIPS_INNER, LIPS_OUTER
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.product_twin import SkinAxes
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from people import clip, clip_points, frame_of

LAYOUTS = (
    "yuv420p", "yuv422p", "yuv444p", "nv12",
    "yuv420p10le", "yuv422p10le", "yuv444p10le",
)  # fmt: skip
BARE = {"opacity": 0.0, "gloss": 0.0, "reflection": 0.0}  # a product that changes nothing
FLAT = {"gloss": 0.0, "reflection": 0.0, "shimmer": 0.0}  # colour alone

device = cache(Device)
NOTHING: Material = None  # type: ignore[assignment] # each test sets its own


@cache
def canvas() -> Canvas:
    return Canvas(device())


def white_light() -> SceneLight:
    """Neutral light of full strength from the front and above, in a grey room."""
    environment = np.full((ENVIRONMENT_PX, ENVIRONMENT_PX, 3), 0.2, np.float32)
    direction = np.array([0, -0.5, -(0.75**0.5)], np.float32)
    return SceneLight(np.ones(3, np.float32), 1.0, direction, environment)


def params(**fixed: float):
    """Any GraphicsParams of the whole space, with gloss up to the largest float."""
    free = {}
    for spec in fields(GraphicsParams):
        low, high = spec.metadata["low"], spec.metadata["high"]
        number = st.floats(low, min(high, 255))
        if high == sys.float_info.max:
            number = st.one_of(st.floats(0, 4), st.floats(0, high))
        free[spec.name] = st.just(fixed[spec.name]) if spec.name in fixed else number
    return st.builds(GraphicsParams, **free)


def product(**given: float) -> GraphicsParams:
    """An opaque matte red with the given changes."""
    plain = {"red": 180, "green": 0, "blue": 46, "opacity": 1, "gloss_roughness": 0.5, **FLAT}
    return GraphicsParams(**{**plain, **given})


def light_of(colour, tilt, strength: float, room: float, seed: int, skin: float) -> SceneLight:
    """Light of a colour (logarithms of red, green, blue) from a direction (x and y)."""
    rgb = np.exp(np.array(colour))
    direction = np.array([*tilt, -np.sqrt(1 - np.square(tilt).sum())])
    environment = np.random.default_rng(seed).uniform(0, room, (16, 16, 3))
    return SceneLight(
        (rgb / (rgb @ (0.2126, 0.7152, 0.0722))).astype(np.float32),
        strength,
        direction.astype(np.float32),
        environment.astype(np.float32),
        skin,
    )


def lights():
    """Any light that can be estimated; its luminance is 1."""
    return st.builds(
        light_of,
        st.tuples(*[st.floats(-1.2, 1.2)] * 3),
        st.tuples(*[st.floats(-0.7, 0.7)] * 2),
        st.floats(0.02, 8), st.floats(0, 4), st.integers(0, 9), st.floats(0, 1),
    )  # fmt: skip


def codings(transfers=(SRGB, PQ, HLG), depths=(8, 10)):
    matrices = st.sampled_from(sorted(LUMA_WEIGHTS))
    primaries = st.sampled_from((1, 6, 9, 12))
    return st.builds(
        Coding, matrices, st.booleans(), st.sampled_from(transfers), primaries,
        st.sampled_from(depths),
    )  # fmt: skip


def place_of(angle: float, skin_px: float) -> SkinAxes:
    turn = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return SkinAxes(np.array(turn), skin_px)


def places():
    """A region at any angle, on a face of any size."""
    return st.builds(place_of, st.floats(-3.2, 3.2), st.floats(4, 1500))


def any_surface(
    seed: int, size_wh: tuple[int, int], place: SkinAxes, brightest: float
) -> PaintedRegion:
    """Every kind of pixel: weights from 0 to 1, from black to bright, even too steep normals."""
    rng = np.random.default_rng(seed)
    w, h = size_wh
    weight = np.clip(rng.uniform(-0.5, 1.5, (h, w)), 0, 1)
    coarse = brightest * rng.uniform(0, 1, (h, w)) ** 3 * (rng.uniform(0, 1, (h, w)) > 0.1)
    coarse = np.pad(coarse, ((0, h < 2), (0, w < 2)), mode="edge")
    normals = rng.uniform(-1.2, 1.2, (2, *coarse.shape)).astype(np.float32)
    # the grid has the rectangle's pixels, or is coarser, turned, and covers only a part of it
    to_grid = (1, 0, 0, 0, 1, 0) if seed % 2 else (0.6, 0.2, 1.3, -0.1, 0.5, 2.0)
    mean = float(rng.choice([0, 0.02, 0.3, brightest]))
    step = np.array([[1, 0], [0, 1]]) / place.skin_px
    to_patch = np.column_stack([step @ np.array(place.turn), rng.uniform(-1, 1, 2)])
    room = rng.uniform(0, brightest, (3, 16, 16)).astype(np.float32)
    exposed = rng.uniform(-0.5, 1.5, (1, *coarse.shape)).clip(0, 1).astype(np.float32)
    return PaintedRegion(
        Rect(0, 0, w, h), weight.astype(np.float32), coarse.astype(np.float32),
        np.concatenate([normals, exposed]),
        to_grid, mean, to_patch.ravel().tolist(), Environment.of(room), NOTHING,
    )  # fmt: skip


def flat_surface(size_wh: tuple[int, int], luminance: float, weight: float = 1.0) -> PaintedRegion:
    """An even patch that faces the viewer, in a dark room."""
    w, h = size_wh
    grid = np.zeros((3, 2, 2), np.float32)
    grid[0] = luminance
    return PaintedRegion(
        Rect(0, 0, w, h), np.full((h, w), weight, np.float32), grid[0], grid[1:],
        (0.01, 0, 0, 0, 0.01, 0), luminance, (0.01, 0, 0, 0, 0.01, 0),
        Environment.of(np.zeros((3, 16, 16), np.float32)), NOTHING,
    )  # fmt: skip


def paint_codes(
    luma: np.ndarray, chroma: np.ndarray, surface: PaintedRegion, lit: Material, coding: Coding
) -> np.ndarray:
    """Paint 4:4:4 codes (h, w) and (2, h, w) with the kernels: (3, h, w) integers."""
    planes = luma.copy(), *chroma.astype(luma.dtype)
    paint_on(planes, [replace(surface, material=lit)], coding, (1, 1))
    return np.stack(planes).astype(int)


def paint_on(planes, surfaces: list[PaintedRegion], coding: Coding, block: tuple[int, int]) -> None:
    """Paint the surfaces on any planes, in place. Surfaces that follow each other on one rectangle
    are painted as its coats."""
    rects, counts = zip(
        *((rect, len(list(same))) for rect, same in groupby(one.rect for one in surfaces)),
        strict=True,
    )
    weights = canvas().place(rects, block, planes[0].dtype, counts)
    for weight, surface in zip(weights, surfaces, strict=True):
        assert not weight.any()
        weight[:] = surface.weight
    placed = [replace(surface, weight=w) for surface, w in zip(surfaces, weights, strict=True)]
    canvas().paint(planes, [one.made() for one in placed], coding)


def any_codes(seed: int, size_wh: tuple[int, int], coding: Coding) -> tuple[np.ndarray, np.ndarray]:
    """Luma and chroma: black, white, ordinary skin, and codes outside every gamut."""
    rng = np.random.default_rng(seed)
    w, h = size_wh
    top, unit = coding.max_code, 2.0 ** (coding.bit_depth - 8)
    codes = rng.integers(0, top + 1, (3, h, w)).astype(np.float64)
    codes[:, 0] = rng.choice([0, top], (3, w))
    codes[1:, 1] = 128 * unit
    skin = np.array([150, 112, 150])[:, None, None] * unit
    codes[:, 2:6] = skin + rng.normal(0, 6 * unit, (3, *codes[0, 2:6].shape))
    whole = np.clip(np.rint(codes), 0, top)
    dtype = np.uint8 if coding.bit_depth == 8 else np.uint16
    return whole[0].astype(dtype), whole[1:].astype(np.float32)


def signed_distance(points_xy: np.ndarray, hw: tuple[int, int]) -> np.ndarray:
    """(H, W) float32 px, positive inside a polygon, accurate to a quarter of a pixel."""
    fine = 4
    big = np.zeros((hw[0] * fine, hw[1] * fine), np.uint8)
    cv2.fillPoly(big, [np.rint((points_xy + 0.5) * fine - 0.5).astype(np.int32)], 1)
    far = cv2.distanceTransform(big, cv2.DIST_L2, 5) - cv2.distanceTransform(
        1 - big, cv2.DIST_L2, 5
    )
    return cv2.resize(far, hw[::-1], interpolation=cv2.INTER_AREA) / fine


def true_face(points_px: np.ndarray, track_id: int = 0, mouth_visible: float = 1.0) -> Face:
    """A face with a lip patch drawn from its points, (478, 2)."""
    face = heads.face(points_px, track_id, mouth_visible=mouth_visible)
    back = cv2.invertAffineTransform(face.lips.to_px)
    hw = face.lips.logits.shape
    outer, inner = (
        signed_distance(points_px[ring] @ back[:, :2].T + back[:, 2], hw)
        for ring in (LIPS_OUTER, LIPS_INNER)
    )
    logits = np.clip(1.1 * np.minimum(outer, -inner), -30, 30)
    return heads.face(points_px, track_id, logits, mouth_visible=mouth_visible)


@cache
def _sample(index: int) -> tuple[np.ndarray, np.ndarray]:
    return clip(index + 1)[index], clip_points(index + 1)[index]


def close_up(index: int = 0, box=(220, 80, 420, 300)) -> tuple[np.ndarray, np.ndarray]:
    """A crop of a frame of the 640 x 360 sample: RGB, and the face's points in the crop."""
    rgb8, points = _sample(index)
    x0, y0, x1, y1 = box
    return np.ascontiguousarray(rgb8[y0:y1, x0:x1]), points - (x0, y0)


def tagged(frame: Frame, tags: ColourTags) -> Frame:
    return Frame(frame.picture, frame.pts, frame.time_base, tags)


def scene_of(frame: Frame, faces: tuple[Face, ...], light: SceneLight | None = None) -> FrameScene:
    """The scene of a single frame; `light` replaces the estimated light."""
    scene = BuildScene()(FrameFaces(frame, faces))
    if light is None:
        return scene
    return replace(scene, faces=tuple(replace(face, light=light) for face in scene.faces))


def close_up_scene(pix_fmt: str = "yuv444p", light: SceneLight | None = None, **box) -> FrameScene:
    rgb8, points = close_up(**box)
    return scene_of(frame_of(rgb8, pix_fmt=pix_fmt), (true_face(points),), light or white_light())


@cache
def painter() -> Composite:
    """One painter for all tests; each test sets its own look."""
    return Composite(Look())


def copied(frame: Frame) -> list[np.ndarray]:
    return [plane.copy() for plane in frame.planes]


def paint_planes(scene: FrameScene, look: Look) -> list[np.ndarray]:
    """The painted planes; the scene's frame is restored, so a test can use the scene again."""
    frame = scene.frame
    fresh = av.VideoFrame(frame.width_px, frame.height_px, frame.pix_fmt)
    target = replace(frame, picture=fresh)
    for new, old in zip(target.writable_planes(), frame.planes, strict=True):
        new[:] = old
    painter().set_look(look)
    return copied(painter()(replace(scene, frame=target)))


def lit_of(face: FaceScene) -> list[Lit]:
    """Every visible surface of a face: the lips, then the lids."""
    return [lit for surfaces in face.regions.values() for lit in surfaces]


def weights_of(scene: FrameScene, look: Look, monkeypatch) -> np.ndarray:
    """(H, W): the largest weight of a look at each pixel of a frame."""
    frame = scene.frame
    total = np.zeros((frame.height_px, frame.width_px), np.float32)

    paint = Canvas.paint

    def paint_and_note(self, planes, regions, coding):
        for region in regions:
            part = region.rect.luma((total,))
            np.maximum(part, region.weight, out=part)
        paint(self, planes, regions, coding)

    with monkeypatch.context() as patch:
        patch.setattr(Canvas, "paint", paint_and_note)
        paint_planes(scene, look)
    return total


def inside(points_px: np.ndarray, hw: tuple[int, int], shrunk_px: float = 0.0) -> np.ndarray:
    """(H, W) bool: the pixels at least shrunk_px inside a contour."""
    within = np.zeros(hw, bool)
    # Only around the contour: the distances of a whole frame would take a hundred times as long.
    margin = max(-shrunk_px, 0) + 2
    x0, y0 = np.maximum(np.floor(points_px.min(axis=0) - margin), 0).astype(int)
    x1, y1 = np.ceil(points_px.max(axis=0) + margin).astype(int) + 1
    part = within[y0 : max(y1, y0), x0 : max(x1, x0)]
    if part.size:
        part[:] = signed_distance(points_px - (x0, y0), part.shape) > shrunk_px
    return within
