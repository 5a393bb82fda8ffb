"""Products of a look under the light of a scene, as kernels/product.cl makes them for painting."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.paint import MadeRegion
from makeup_video.kernels.planes import Rect
from makeup_video.kernels.product import COAT, CODING, LitRegion, ProductKernel
from makeup_video.kernels.program import Device
from makeup_video.pipeline.render.coats import PaintJob, WornCoat
from makeup_video.pipeline.render.environment import blur_matrix, room_colours
from makeup_video.pipeline.render.product_material import (
    LUMINANCE,
    ceiling_of,
    film_matrices,
    least_cell,
    sparing,
    unlit,
)

# A job, and the rectangle of the picture that holds all its weight.
PlacedJob = tuple[PaintJob, Rect]


def made_regions(
    placed: Sequence[PlacedJob], weights: Sequence[np.ndarray], coding: Coding, device: Device
) -> list[MadeRegion]:
    """The regions that a canvas paints, one for each job and its weight.

    They are valid until the next call with this device.
    """
    lit = [_lit(job, rect) for job, rect in placed]
    products, words = device.once(ProductKernel)(lit, coding_record(coding))
    return [
        MadeRegion(
            rect, weight, job.part.lit.shading, job.surface.normals, job.part.lit.mean, product,
            word, job.part.shares,
        )
        for (job, rect), weight, product, word in zip(
            placed, weights, products, words, strict=False
        )
    ]  # fmt: skip


def _lit(job: PaintJob, rect: Rect) -> LitRegion:
    (a, b, x), (c, d, y) = job.surface.grid.to_px.tolist()
    light = job.light
    return LitRegion(
        (a, b, x - rect.x, c, d, y - rect.y), job.skin_px, coat_records(job.coats),
        job.amount, light.strength_for_products * job.shade, light.colour.tolist(),
        light.direction.tolist(), light.environment, job.part.seen,
    )  # fmt: skip


@lru_cache(maxsize=64)
def coat_records(coats: tuple[WornCoat, ...]) -> np.ndarray:
    """(N,) records of COAT."""
    return np.array([_coat_record(coat) for coat in coats], COAT)


def _coat_record(coat: WornCoat) -> tuple[object, ...]:
    params, whole = coat.product, unlit(coat.product)
    return (
        coat.strength, params.light_adaptation, *whole.lights, params.opacity, params.texture_keep,
        params.undertone, coat.kind.kept_highlights(params), whole.own_highlights, whole.lobe,
        params.reflection, whole.fresnel_front, whole.fresnel_rim, whole.room, whole.shimmer,
        *least_cell(params), *sparing(coat.kind.spared), blur_matrix(params).T,
    )  # fmt: skip


@lru_cache
def coding_record(coding: Coding) -> np.ndarray:
    to_film, from_film = film_matrices(coding.primaries)
    room = room_colours(coding.primaries).ravel()
    return np.array((LUMINANCE, to_film, from_film, room, ceiling_of(coding)), CODING)
