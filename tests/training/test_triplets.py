"""The evaluation of reference nets: triplets, scores, the baseline tool and the page."""

from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.reference.crops import CROPPED, to_targets
from makeup_video.training.reference import draw_products, read_look, triplets
from makeup_video.training.reference.baselines import transfer_mean_colour
from makeup_video.training.reference.picture_metrics import ciede2000, crop_face, face_crop_to_px
from makeup_video.training.reference.rendered_crops import to_rgb8
from people import portrait

RED = np.array([0.95, 190, 10, 30, 0.3, 0.5, 0.05])
PEOPLE = 6


@cache
def face() -> Face:
    return find_faces(portrait())[0]


class SamePeople:
    """Stands in for People, with several copies of the sample's portrait."""

    share = np.full(PEOPLE, 1 / PEOPLE)
    tone = np.array([1, 4, 4, 2, 1, 4])

    def __len__(self):
        return PEOPLE

    def rgb8(self, person):
        return portrait()

    def face(self, person):
        return face()


def products():
    return draw_products.RealProducts(np.tile(RED, (5, 1)))


def made(region, count=2, seed=0):
    people = SamePeople()
    worn = {
        worn_region: products() for worn_region in ((region,) if region in CROPPED else CROPPED)
    }
    return list(triplets.triplets(people, *triplets.halves(people), worn, count, seed))


def knowing(values):
    """A net that returns these numbers for any picture."""
    return lambda rgb8: np.tile(to_targets(values), (len(rgb8), 1))


def test_the_halves_share_no_person_and_leave_none_out():
    wearers, others = triplets.halves(SamePeople())
    assert sorted([*wearers, *others]) == list(range(PEOPLE))


@pytest.mark.parametrize("region", (*CROPPED, "both"))
def test_a_triplet_is_painted_where_it_says_and_only_there(region):
    for triplet in made(region):
        bare = to_rgb8(triplet.bare.codes)
        assert triplets.worn(triplet.look) == ([region] if region in CROPPED else list(CROPPED))
        assert triplet.photo.shape == triplet.truth.shape == bare.shape
        touched = (triplet.truth != bare).any(-1)
        assert touched[triplet.where].mean() > 0.9
        assert triplet.where.sum() > 0.2 * touched.sum() and touched.mean() < 0.1


def test_the_same_seed_gives_the_same_triplets():
    first, again, other = (made("lips", 1, seed)[0] for seed in (1, 1, 2))
    assert first.look == again.look and (first.photo == again.photo).all()
    assert first.look != other.look


def test_products_of_a_colour_have_it_and_cover():
    drawn = triplets.OfColour(products(), (20, 50, 200)).draw(200, np.random.default_rng(0))
    assert np.allclose(drawn[:, 1:4].mean(0), (20, 50, 200), atol=4)
    assert (drawn[:, 0] >= 0.6).all() and (drawn[:, 1:4] >= 0).all()


def test_a_look_of_numbers_keeps_them():
    look = read_look.look_with({"lips": RED, "eyes": RED / 2}, "outer")
    assert np.allclose(triplets.numbers_of(look, "lips"), RED)
    assert np.allclose(triplets.numbers_of(look, "eyes"), RED / 2) and look.zone == "outer"


def test_a_look_is_read_from_a_photo_that_has_a_face(tmp_path):
    nets = {"lips": knowing(RED)}
    look = read_look.paper_look(portrait(), nets)
    read = triplets.numbers_of(look, "lips")
    assert np.allclose(read, RED, atol=1e-3) and look.eyes is None
    assert read_look.paper_look(np.full((300, 300, 3), 90, np.uint8), nets) is None
    with pytest.raises(ValueError, match="nets must hold one of lips or eyes, got none"):
        read_look.paper_look(portrait(), read_look.nets_of(tmp_path))


def test_a_net_in_a_folder_is_found_by_its_region(tmp_path):
    assert read_look.file_of(tmp_path, "lips") is None
    (tmp_path / "lips-lite0.pt").touch()
    assert read_look.file_of(tmp_path, "lips").name == "lips-lite0.pt"
    (tmp_path / "reference_lips.onnx").touch()
    assert read_look.file_of(tmp_path, "lips").name == "reference_lips.onnx"
    assert read_look.nets_of(tmp_path / "nowhere") == {}


def test_the_simple_tool_moves_the_mean_and_nothing_outside():
    rng = np.random.default_rng(0)
    source = rng.integers(90, 130, (20, 30, 3)).astype(np.uint8)
    reference = np.full((10, 10, 3), (170, 60, 70), np.uint8)
    weight = np.zeros((20, 30), np.float32)
    weight[5:15, 5:25] = 1
    out = transfer_mean_colour(reference, np.ones((10, 10)), source, weight)
    assert (out[weight == 0] == source[weight == 0]).all()
    inside = weight == 1
    assert ciede2000(out.mean((0, 1), where=inside[..., None])[None, None].round().astype(np.uint8),
                     reference[:1, :1], np.ones((1, 1), bool)) < 3  # fmt: skip
    assert out[inside].std() > 5  # its own detail
    assert (transfer_mean_colour(reference, np.zeros((10, 10)), source, weight) == source).all()


def test_the_face_fills_the_square_that_whole_scores_see():
    to_px = face_crop_to_px(face())
    low, high = face().points_px[:, :2].min(0), face().points_px[:, :2].max(0)
    corners = np.linalg.inv(to_px[:, :2]) @ (np.stack([low, high], 1) - to_px[:, 2:])
    assert (corners > 0).all() and (corners < 255).all() and np.ptp(corners, axis=1).max() > 220
    assert crop_face(portrait(), to_px).shape == (256, 256, 3)


def test_whole_scores_are_0_for_the_same_and_grow():
    pytest.importorskip("pytorch_msssim")
    from makeup_video.training.reference.picture_metrics import whole_scores

    truth = crop_face(portrait(), face_crop_to_px(face()))
    noise = np.random.default_rng(0).normal(0, 1, truth.shape)
    near, far = ((truth + k * noise).clip(0, 255).astype(np.uint8) for k in (4, 40))
    found = whole_scores()([truth, near, far], truth)
    assert np.allclose(found[0, :2], 0, atol=1e-6) and np.isnan(found[:, 2]).all()
    assert (np.diff(found[:, :2], axis=0) > 0).all()
    assert found[1, 0] == pytest.approx(np.abs(near / 255 - truth / 255).mean(), rel=1e-4)


def lpips_files(folder):
    """Files in the format of the published weights, with other numbers."""
    import torch
    from makeup_video.training.reference import lpips

    torch.manual_seed(0)
    net = lpips.Lpips()
    alexnet = {f"features.{key[6:]}": value for key, value in net.convs.state_dict(prefix="convs.").items()}  # fmt: skip
    heads = {f"lin{key[0]}.model.1.weight": value.abs() for key, value in net.heads.state_dict().items()}  # fmt: skip
    torch.save({**alexnet, "classifier.1.bias": torch.zeros(2)}, folder / "alexnet.pth")
    torch.save(heads, folder / "alex.pth")
    return folder / "alexnet.pth", folder / "alex.pth"


def test_lpips_takes_published_weights_and_misses_none(tmp_path):
    torch = pytest.importorskip("torch")
    from makeup_video.training.reference import lpips

    files = lpips_files(tmp_path)
    net = lpips.load(files)
    a, b = torch.rand(2, 3, 64, 64), torch.rand(2, 3, 64, 64)
    assert (net(a, a) == 0).all() and (net(a, b) > 0).all() and net(a, b).shape == (2,)
    with pytest.raises(ValueError, match=r"heads\.0"):
        lpips.load(files[:1])


def test_true_numbers_score_well_and_a_bare_face_badly():
    pytest.importorskip("torch")
    from makeup_video.training.reference import evaluate

    nets = {"lips": knowing(RED), "eyes": knowing(RED)}
    found = evaluate.measure(made("lips", 6), {"ours": nets})
    assert found.unread == 0 and all(each.shape == (6, 7) for each in found.pair("ours", "lips"))
    assert set(found.scores) == {"ours", evaluate.TRUE, evaluate.MEAN, evaluate.SOURCE}
    best, bare = (np.median(found.only(name)) for name in (evaluate.TRUE, evaluate.SOURCE))
    assert best < 2 and bare > 5
    assert np.isnan(found.only("ours", "L1")).all()


def test_the_whole_product_reads_a_strong_lipstick():
    pytest.importorskip("torch")
    from makeup_video.training.reference import evaluate

    nets = {"lips": knowing(RED), "eyes": knowing(RED)}
    found = evaluate.measure(made("lips", 4), {"ours": nets}, with_product=True)
    read, bare = (np.median(found.only(name)) for name in (evaluate.PRODUCT, evaluate.SOURCE))
    assert read < bare / 2
    assert np.ptp(found.pair("ours", "lips")[1], axis=0).max() < 1e-3  # the net always returns RED
    assert np.median(found.only("ours")) < bare / 2


def test_a_photo_without_a_face_leaves_the_source_as_it_is(monkeypatch):
    pytest.importorskip("torch")
    from makeup_video.training.reference import evaluate

    photos = iter([lambda rgb8: None, read_look.see])  # no face in the first photo only
    monkeypatch.setattr(evaluate, "see", lambda rgb8: next(photos)(rgb8))
    nets = {"ours": {"lips": knowing(RED), "eyes": knowing(RED)}, "half": {"eyes": knowing(RED)}}
    found = evaluate.measure(made("lips", 2), nets)
    assert found.unread == 1 and len(found.tone) == 2 and len(found.pair("ours", "lips")[1]) == 1
    assert found.only("ours")[0] == found.only(evaluate.SOURCE)[0] > found.only("ours")[1]
    assert "half" not in found.scores


def test_colour_errors_count_where_they_are_visible():
    pytest.importorskip("torch")
    from makeup_video.training.reference import evaluate

    true = np.tile(RED, (2, 1))
    true[1, 0] = 0.1
    estimated = true + np.array([0.1, 3, 6, 9, 0, 0, 0])
    estimated[1, 1:4] += 100
    assert evaluate.colour_error(true, estimated) == pytest.approx(6)
    assert np.allclose(draw_products.number_errors(true, estimated), [0.1, 3, 6, 9, 0, 0, 0])
    assert np.isnan(evaluate.colour_error(true[1:], estimated[1:]))


def test_the_page_shows_misses_first_and_keeps_written_notes(monkeypatch, tmp_path):
    pytest.importorskip("torch")
    from makeup_video.training.reference import evaluate

    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "docs" / "make"))
    page = import_module("results_page")
    nets = {"ours": {region: knowing(RED) for region in CROPPED}}
    main = {worn: evaluate.measure(made(worn), nets) for worn in (*CROPPED, "lips and eyes")}
    kinds = {region: {"blue": main[region]} for region in CROPPED}
    cost = read_look.Cost(1.5, {1: 2.0, 2: 1.0})
    results = page.Results(main, kinds, kinds, {}, ["ours"], {"ours": {"lips": cost}})
    text = page.text(results)
    marks = [line.endswith("| **missed** |") for line in page.reach(results).splitlines()[2:]]
    # no rows for L1 and the like, which are not measured
    assert marks == sorted(marks, reverse=True) and len(marks) == 10
    assert "| ours | lips | 1.5 | 2.0 | 1.0 |" in text and "not measured" in text
    path = tmp_path / "results.md"
    path.write_text(text + "\n* dark lips\n", encoding="utf-8")
    kept_after = import_module("contact_sheet").kept_after
    assert kept_after(path, page.JUDGEMENT) == "\n* dark lips\n"
    assert kept_after(tmp_path / "none.md", page.JUDGEMENT) == ""
