"""The training data of the net that reads what is worn, and the scores it is judged by."""

from argparse import Namespace
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Look, apply_look, find_faces
from makeup_video.pipeline.look.ready import ready_look
from makeup_video.pipeline.reference.makeup_input import INPUT_WH
from makeup_video.pipeline.render.apply_look import PaintPictures
from makeup_video.training.worn.bare_skin import Response
from makeup_video.training.worn.draw_looks import draw_look
from makeup_video.training.worn.evaluate import calibrated
from makeup_video.training.worn.fit_colours import fit
from makeup_video.training.worn.prepare import LABELS, pack, painted, rows, rows_without_labels
from makeup_video.training.worn.real_photos import BEGIN, END, Worn, section
from makeup_video.training.worn.scores import UNKNOWN, area_under_curve
from makeup_video.training.worn.zones import ZONES, Transfer, see
from people import SAMPLES

PICTURE = np.ascontiguousarray(cv2.imread(str(SAMPLES / "portrait.jpg"))[..., ::-1])


def test_drawn_looks_are_labelled_by_what_they_change():
    (face,) = find_faces(PICTURE)
    rng, paint = np.random.default_rng(3), PaintPictures()
    found = set()
    for _ in range(6):
        look = draw_look(rng, {"lips": ["#B4002E"], "eyes": ["#5A3A2E"]})
        seen, labels = painted(PICTURE, face, look, paint)
        assert seen.shape == (*INPUT_WH[::-1], 3)
        for label, kind in zip(labels, LABELS.values(), strict=True):
            assert label in (0, 1, UNKNOWN) and (label != 1 or look.of(kind))
            found.add(label)
    assert {0, 1} <= found


def test_labels_are_read_and_unusable_faces_left_out(tmp_path):
    (tmp_path / "worn.csv").write_text(
        "name,lips,shadow,liner,blush,flags\na.jpg,0,1,2,0,\nb.jpg,2,0,0,0,x\nc.jpg,0,2,0,0,h\n"
    )
    known = {path.name: labels for path, labels in rows(tmp_path)}
    assert known == {"a.jpg": [0, UNKNOWN, 1, 0], "c.jpg": [UNKNOWN, 1, UNKNOWN, UNKNOWN]}


@pytest.mark.parametrize("read", [rows, rows_without_labels])
def test_a_set_without_a_folder_is_refused(tmp_path, read):
    with pytest.raises(SystemExit, match=r"there is no folder .*nowhere: name the sets"):
        list(read(tmp_path / "nowhere"))


def test_names_with_commas_and_accents_are_read(tmp_path):
    names = ["rose, matte.jpg", "\u00e9clat.jpg"]
    for name in names:
        (tmp_path / name).touch()
    table = f'name,lips,shadow,liner,blush,flags\n"{names[0]}",0,1,2,0,\n{names[1]},2,0,0,0,\n'
    (tmp_path / "worn.csv").write_text(table, encoding="utf-8")
    assert [path.name for path, _ in rows(tmp_path)] == names
    assert list(rows_without_labels(tmp_path)) == []


def test_a_kind_is_labelled_by_its_own_paint():
    """Faint blush is labelled as if it were worn alone, whatever else is worn."""
    (face,) = find_faces(PICTURE)
    layers = ready_look("clown").look.layers
    look = Look(replace(one, strength=0.02) if one.kind == "blush" else one for one in layers)
    assert {"lipstick", "eyeshadow", "blush"} <= {one.kind for one in look.layers}
    together, alone = (
        dict(zip(LABELS, painted(PICTURE, face, one, PaintPictures())[1], strict=True))
        for one in (look, Look(look.of("blush")))
    )
    assert together["blush"] == alone["blush"] != 1
    assert together["lips"] == together["shadow"] == 1


@given(st.lists(st.tuples(st.integers(-9, 9), st.booleans()), min_size=2, max_size=40))
def test_the_area_is_the_share_of_pairs_in_the_right_order(pairs):
    scores = np.array([score for score, _ in pairs])
    worn = np.array([is_worn for _, is_worn in pairs])
    if worn.all() or not worn.any():
        assert np.isnan(area_under_curve(scores, worn))
        return
    right = np.mean([(a > b) + (a == b) / 2 for a in scores[worn] for b in scores[~worn]])
    assert abs(area_under_curve(scores, worn) - right) < 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_calibrated_scores_are_probabilities(seed):
    rng = np.random.default_rng(seed)
    scores = rng.normal(0, 2, (6000, 2))
    true = 0.7 * scores[:, 0] + 0.2 * scores[:, 1] - 1
    worn = rng.random(6000) < 1 / (1 + np.exp(-true))
    *scales, shift = calibrated(scores, worn)
    np.testing.assert_allclose([*scales, shift], [0.7, 0.2, -1], atol=0.12)


def test_a_score_that_would_be_turned_round_is_left_out():
    rng = np.random.default_rng(0)
    good = rng.normal(0, 1, 500)
    scores = np.stack([good, -good + rng.normal(0, 1, 500)], 1)
    scales = calibrated(scores, good + rng.normal(0, 0.5, 500) > 0)
    assert scales[0] > 0 and scales[1] >= 0


def test_the_colour_model_finds_what_tells_the_labels_apart():
    rng = np.random.default_rng(1)
    numbers = rng.normal(0, [1, 5, 0.1], (900, 3))
    weights = fit(numbers, numbers[:, 2] > 0.05, ridge=1.0)
    right = (numbers @ weights[:-1] + weights[-1] > 0) == (numbers[:, 2] > 0.05)
    assert right.mean() > 0.95


@given(st.floats(0.1, 1), st.floats(0.1, 1))
def test_cover_and_response_are_found_again(cover, response):
    rng, fitted = np.random.default_rng(2), Response()
    for _ in range(5):
        bare, added = rng.random((4, 3)), rng.random((4, 3))
        fitted.add(bare, (1 - cover) * bare + response * added, added)
    found = fitted.solve()
    np.testing.assert_allclose(found[0], cover, atol=1e-6)
    np.testing.assert_allclose(found[1], response, atol=1e-6)


def test_a_look_on_the_same_face_comes_across():
    (face,) = find_faces(PICTURE)
    look = ready_look("clown").look
    photo = see(apply_look(PICTURE, look, [face]), face)
    for read, least, most in ((look, 0.99, 1.01), (Look(), -0.01, 0.01)):
        transfer = Transfer([see(PICTURE, face)] * 3)
        transfer.add(photo, read, lambda seen, look: apply_look(seen.rgb8, look, [seen.face]))
        assert transfer.photos["lips"] == transfer.photos["lid"] == 1
        assert least <= transfer.score(*ZONES) <= most


def test_the_section_has_a_row_for_each_kind_and_zone():
    (face,) = find_faces(PICTURE)
    worn = {name: Worn([0.1, 0.2, 0.9], [0.8, 0.95]) for name in LABELS}
    text = section(worn, worn, [worn], Transfer([see(PICTURE, face)] * 3))
    for name in (*LABELS.values(), *ZONES):
        assert f"| {name} |" in text
    assert "33 %" in text and BEGIN not in text and END not in text


def test_packed_faces_have_all_that_is_read_later(tmp_path):
    (tmp_path / "faces").mkdir()
    cv2.imwrite(str(tmp_path / "faces" / "one.jpg"), PICTURE[..., ::-1])
    for name in ("lip_shades.csv", "eyeshadow_shades.csv"):
        (tmp_path / name).write_text("hex\n#B4002E\n")
    out = tmp_path / "packed.npz"
    pack(
        Namespace(
            faces=tmp_path,
            sets=["faces"],
            shades=tmp_path,
            looks=1,
            seed=0,
            out=out,
            unlabelled=False,
        )
    )
    with np.load(out) as packed:
        assert {len(packed[name]) for name in packed} == {2}  # bare, and with a look
        assert {"inputs", "labels", "vectors", "weights", "sources", "real", "colours"} == set(
            packed
        )
