"""What holds for every kind of makeup, whatever its shape and its product."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from laws import same
from layers import SHOWN, densities, everything, job_weight, jobs, layer_lists, layers
from makeup import BARE, close_up_scene, copied, device, lit_of, paint_planes
from makeup_video.kernels.material import ENVIRONMENT_PX, MATERIAL
from makeup_video.kernels.material_twin import Environment, Material
from makeup_video.kernels.paint import FAINT, Canvas, MadeRegion
from makeup_video.kernels.paint_twin import Layers, PaintedRegion, paint_twin
from makeup_video.pipeline.frames.affine import compose
from makeup_video.pipeline.look.finishes import FINISHES
from makeup_video.pipeline.look.finishes import product as finished
from makeup_video.pipeline.look.kinds import KINDS, PAINTED
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.render.coats import groups_of
from makeup_video.pipeline.render.regions import REGIONS
from makeup_video.pipeline.render.surfaces.region import Reader

few_examples = settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
any_kind = pytest.mark.parametrize("kind", KINDS)
HALF = np.array([[0.5, 0, -0.25], [0, 0.5, -0.25]])


def surfaces_of(kind):
    """The surfaces of the close-up that a kind is painted on."""
    scene = close_up_scene()
    return [
        lit.surface
        for lit in REGIONS[KINDS[kind].region].lit(scene, scene.faces[0], Reader(device()))
    ]


def size_of(scene):
    return scene.frame.width_px, scene.frame.height_px


def shown(kind, finish="satin", rgb=(200, 20, 60)):
    return Layer(kind, finished(rgb, finish, KINDS[kind].part), SHOWN.get(kind, {}))


@any_kind
@pytest.mark.parametrize("finish", FINISHES)
def test_every_finish_changes_the_picture(kind, finish):
    scene = close_up_scene("yuv420p")
    assert not same(paint_planes(scene, Look([shown(kind, finish)])), copied(scene.frame))


@any_kind
@few_examples
@given(data=st.data())
def test_a_product_without_effect_leaves_every_byte(kind, data):
    layer = data.draw(layers(kind, **BARE))
    scene = close_up_scene("yuv420p")
    assert same(paint_planes(scene, Look([layer])), copied(scene.frame))


@any_kind
@few_examples
@given(data=st.data())
def test_no_strength_leaves_every_byte(kind, data):
    layer = replace(data.draw(layers(kind)), strength=0.0)
    scene = close_up_scene("yuv420p")
    assert same(paint_planes(scene, Look([layer])), copied(scene.frame))


def near(rects, shape):
    mask = np.zeros(shape, bool)
    for rect in rects:
        mask[rect.y : rect.y + rect.height, rect.x : rect.x + rect.width] = True
    return mask


@any_kind
@few_examples
@given(data=st.data())
def test_only_bytes_within_the_rects_of_the_jobs_change(kind, data):
    layer, scene = data.draw(layers(kind)), close_up_scene()
    rects = [job.rect(size_of(scene), (1, 1)) for job in jobs(scene, [layer])]
    mask = near([rect for rect in rects if rect is not None], scene.frame.planes[0].shape)
    for old, new in zip(copied(scene.frame), paint_planes(scene, Look([layer])), strict=True):
        assert not ((old != new) & ~mask).any()


@any_kind
@few_examples
@given(data=st.data())
def test_the_rect_of_a_job_holds_all_its_weight(kind, data):
    scene = close_up_scene()
    wide, high = size_of(scene)
    for job in jobs(scene, [data.draw(layers(kind))]):
        weight = job_weight(job, (high, wide))
        assert weight.dtype == np.float32 and weight.min() >= 0 and weight.max() <= 1
        rect = job.rect((wide, high), (1, 1))
        mask = near([] if rect is None else [rect], weight.shape)
        assert weight[~mask].max(initial=0) == 0


@any_kind
@few_examples
@given(data=st.data())
def test_no_byte_changes_beyond_the_grids_of_the_surfaces(kind, data):
    scene, layer = close_up_scene(), data.draw(layers(kind))
    x, y = np.meshgrid(*map(np.arange, size_of(scene)))
    mask = np.zeros(x.shape, bool)
    for surface in surfaces_of(kind):
        low, high = surface.grid.box_px((0, 0, *surface.grid.size_wh), more=1)
        mask |= (x >= low[0]) & (y >= low[1]) & (x <= high[0]) & (y <= high[1])
    assert not mask.all()
    for old, new in zip(copied(scene.frame), paint_planes(scene, Look([layer])), strict=True):
        assert not ((old != new) & ~mask).any()


@any_kind
@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_densities_are_finite_and_as_large_as_the_grid(kind, data):
    layer, info = data.draw(layers(kind)), KINDS[kind]
    surfaces = surfaces_of(kind)
    for side in zip(*(surface.sides() for surface in surfaces), strict=True):
        shape = len(side), *side[0].normals.shape[1:]
        with np.errstate(invalid="raise", divide="raise"):
            coats = info.coats(side[0].fields(), layer.product, layer.whole_shape)
        assert not info.is_line or len(coats) == 1
        for coat in coats:
            assert bool(coat.strokes) == info.is_line and 1 <= coat.blur_px < 1000
            if coat.density is not None:
                assert coat.density.shape == shape and coat.density.dtype == np.float32
                assert coat.density.min() >= 0 and coat.density.max() <= 1
            for border in (one for stroke in coat.strokes for one in (stroke.above, stroke.below)):
                assert border.shape == shape and border.dtype == np.float32
                assert np.isfinite(border).all()


CHARTED = [
    Layer(name, finished((90, 20, 60), "satin", kind.part), shape)
    for name, kind in KINDS.items()
    if not kind.is_line
    for shape in [*({"slot": slot} for slot in kind.slots), SHOWN[name]]
]


@pytest.mark.parametrize("layer", CHARTED, ids=lambda layer: f"{layer.kind} {layer.shape}")
def test_a_chart_has_the_densities_of_the_places(layer):
    """Between two px of a chart, curved borders are straight: 0.02 of the density. Places of the
    whole face that this face does not show are left out."""
    (group,) = groups_of(Look([layer]).painted)
    for surface in surfaces_of(layer.kind):
        shown = getattr(surface, "visible", np.ones(surface.normals.shape[1:])) > 0
        at_places: dict = {}
        for side, density in densities(surface, layer):
            whole = np.ones(shown.shape, np.float32) if density is None else density
            at_places.setdefault(side.chart, []).append(whole)
        on_sides = [np.stack(wanted)[:, None] for wanted in at_places.values()]
        wanted = surface.join(on_sides) if len(on_sides) > 1 else on_sides[0]
        wanted = wanted[:, surface.number if wanted.shape[1] > 1 else 0]
        (drawn,), at = group.on(surface), surface.number
        got = np.ones((1, *shown.shape))
        if drawn.charts is not None:
            # coats of opacity 0 hide nothing, so that the share of each is its density
            laid = surface.lay(drawn.charts, [0.0] * len(drawn.coats), device())
            got = laid.density[at][None] if laid.shares is None else laid.shares[:, at]
        assert np.abs(got - wanted)[:, shown].max() < 0.02


@any_kind
def test_a_scaled_surface_lies_on_the_scaled_picture(kind):
    for surface in surfaces_of(kind):
        small = surface.scaled(HALF)
        np.testing.assert_allclose(small.grid.to_px, compose(HALF, surface.grid.to_px))
        np.testing.assert_array_equal(small.normals, surface.normals)


@any_kind
def test_light_and_amount_of_a_region_are_shares(kind):
    face, region = close_up_scene().faces[0], REGIONS[KINDS[kind].region]
    assert 0 <= region.amount(face) <= 1
    for lit in lit_of(face):
        assert 0 < region.shade(face.light, lit.mean) <= 1


def read_back(made: MadeRegion) -> PaintedRegion:
    """What `PaintedRegion.made` was made from, in float32."""
    product, layers = made.product, None
    if made.shares is not None:
        numbers = product["layers"][: product["layer_count"]].tolist()
        layers = Layers(made.shares, numbers, (product["mean_root"] / FAINT).tolist())
    words = made.words.view(np.uint32).reshape(ENVIRONMENT_PX, ENVIRONMENT_PX)
    fields = (product["material"][name].tolist() for name in MATERIAL.names or ())
    return PaintedRegion(
        made.rect, made.weight, made.shading, made.normals, product["to_grid"].tolist(), made.mean,
        product["to_patch"].tolist(), Environment(words, float(product["room_step"])),
        Material(*fields), layers,
    )  # fmt: skip


@pytest.fixture
def twins(monkeypatch):
    """A list that gets, at every painting, the kernels' planes and those of the numpy twin."""
    seen, paint = [], Canvas.paint

    def paint_both(self, planes, regions, coding):
        block = self._kind[0]
        want = paint_twin(planes, [read_back(one) for one in regions], coding, block)
        before = [plane.copy() for plane in planes]
        paint(self, planes, regions, coding)
        assert not same(before, planes)
        seen.append(([plane.copy() for plane in planes], want))

    monkeypatch.setattr(Canvas, "paint", paint_both)
    return seen


@any_kind
@pytest.mark.parametrize("finish", FINISHES)
@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuv444p10le"])
def test_kernels_match_numpy_within_one_code_value(kind, finish, pix_fmt, twins):
    info, scene = KINDS[kind], close_up_scene(pix_fmt)
    worn = [replace(shown(kind, finish), shape={"slot": slot}) for slot in info.slots]
    for layer in worn or [shown(kind, finish)]:
        paint_planes(scene, Look([layer]))
    paint_planes(scene, Look((worn or [shown(kind, finish)])[: info.most]))  # several in one go
    assert len(twins) > len(worn)
    for got, want in twins:
        for plane, wanted in zip(got, want, strict=True):
            # both round once, but from floats of different widths
            assert np.abs(plane.astype(int) - wanted).max() <= 1


@few_examples
@given(layer_lists(), st.permutations(list(KINDS)))
def test_the_order_of_kinds_in_a_file_does_not_matter(some, order):
    scene = close_up_scene("yuv420p")
    as_dicts = [layer.to_dict() for kind in order for layer in some if layer.kind == kind]
    look = Look.from_dict({"version": 2, "layers": as_dicts})
    assert [layer.kind for layer in look.layers] == sorted(
        (layer.kind for layer in some), key=PAINTED.index
    )
    assert same(paint_planes(scene, look), paint_planes(scene, Look(some)))


def test_all_kinds_at_once_are_one_after_the_other():
    """Kinds are painted in the order of the registry. All together may be painted at half the
    resolution, which spreads them by two of its pixels."""
    scene = close_up_scene("yuv444p")
    worn = everything(gloss=0.5, gloss_roughness=0.3)
    assert [layer.kind for layer in worn.layers] == list(PAINTED)
    moved = [np.zeros_like(plane, bool) for plane in scene.frame.planes]
    for layer in worn.layers:
        for mask, old, new in zip(
            moved, scene.frame.planes, paint_planes(scene, Look([layer])), strict=True
        ):
            assert (old != new).any()
            mask |= old != new
    for mask, old, new in zip(moved, scene.frame.planes, paint_planes(scene, worn), strict=True):
        near = cv2.dilate(mask.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
        assert ((old != new) <= near).all() and (old != new).sum() > 0.9 * mask.sum()


@any_kind
def test_densities_are_made_for_every_side_of_a_surface(kind):
    seen = [
        density for surface in surfaces_of(kind) for _, density in densities(surface, shown(kind))
    ]
    assert seen
