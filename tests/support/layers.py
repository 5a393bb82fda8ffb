"""Layers of every kind of makeup: any that may be in a look, and their weight on a face."""

from collections.abc import Iterable

import numpy as np
from hypothesis import strategies as st
from looks import shapes
from makeup import device, params, product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.render.coats import PaintJob, groups_of, jobs_of
from makeup_video.pipeline.render.scene import FrameScene
from makeup_video.pipeline.render.strokes_twin import draw_strokes
from makeup_video.pipeline.render.surfaces.region import Reader
from makeup_video.pipeline.render.surfaces.surface import Edge, Surface

SLOTS = tuple(KINDS["eyeshadow"].slots)
UPPER_SLOTS = tuple(slot for slot, shape in KINDS["eyeshadow"].slots.items() if shape["low"] >= 0)


def layers(kind: str, **fixed: float):
    """Any layer of a kind, with all parameters free but those that are given."""
    return st.builds(Layer, st.just(kind), params(**fixed), shapes(KINDS[kind]), st.floats(0, 1))


def layer_lists(**fixed: float):
    """The layers of any look, in any order."""
    of_kinds = [st.lists(layers(kind.name, **fixed), max_size=kind.most) for kind in KINDS.values()]
    together = st.tuples(*of_kinds).map(lambda groups: [one for group in groups for one in group])
    return together.flatmap(st.permutations)


def looks(**fixed: float):
    return st.builds(Look, layer_lists(**fixed), st.floats(0, 1))


def everything(**given: float) -> Look:
    """All kinds at once, each with a product of the given settings and a shape that shows."""
    return Look(Layer(name, product(**given), SHOWN.get(name, {})) for name in KINDS)


# Shapes in which a kind shows all that it can do.
SHOWN = {name: dict(kind.shown) for name, kind in KINDS.items()} | {"lipstick": {"rim": 0.5}}


def jobs(scene: FrameScene, layers: Iterable[Layer]) -> list[PaintJob]:
    """The paint jobs of some layers on all faces of a scene."""
    groups = groups_of(Look(layers).painted)
    return [job for face in scene.faces for job in jobs_of(scene, face, groups, Reader(device()))]


def job_weight(
    job: PaintJob, hw: tuple[int, int], origin_xy: tuple[int, int] = (0, 0)
) -> np.ndarray:
    """(h, w) float32: the weight of a job on the pixels from origin_xy on, in its rect or not."""
    out = np.full(hw, np.nan, np.float32)
    if job.is_line:
        grid, strokes = job.surface.grid, job.part.strokes
        draw_strokes(
            out, origin_xy, grid, strokes, job.line().blur_px, job.line().soft_px, job.share
        )
    else:
        job.weigh(out, origin_xy)
    return out


def layer_weight(scene: FrameScene, layer: Layer) -> np.ndarray:
    """(H, W) float32: the largest weight of a layer at each pixel of a frame."""
    hw = scene.frame.height_px, scene.frame.width_px
    weights = [job_weight(job, hw) for job in jobs(scene, [layer])]
    return np.max([np.zeros(hw, np.float32), *weights], axis=0)


def densities(surface: Surface, layer: Layer) -> list[tuple[Surface, np.ndarray | None]]:
    """The sides of a surface, each with the density of every coat of a layer, (H, W)."""
    kind = KINDS[layer.kind]
    return [
        (side, None if coat.density is None else coat.density[surface.number])
        for side in surface.sides()
        for coat in kind.coats(side.fields(), layer.product, layer.whole_shape)
    ]


def surface_weight(
    surface: Surface, layer: Layer, hw: tuple[int, int], origin_xy: tuple[int, int] = (0, 0)
) -> np.ndarray:
    """(h, w) float32: the largest weight of a layer on the pixels from origin_xy on, on all sides
    of one surface."""
    edge, weights = Edge(layer.product.edge_softness), []
    for side, density in densities(surface, layer):
        weights.append(np.full(hw, np.nan, np.float32))
        side.weigh(weights[-1], origin_xy, edge, density)
    return np.max(weights, axis=0)


def shadow(slot: str = "lid", softness: float = 0.5) -> Layer:
    """Eyeshadow in a slot, with the borders of a product of this softness."""
    return Layer("eyeshadow", product(edge_softness=softness), {"slot": slot})


def lipstick(softness: float = 0.5) -> Layer:
    return Layer("lipstick", product(edge_softness=softness))
