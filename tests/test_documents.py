"""The pages made from the code say what the code says now, and their pictures are there and small."""

import re
from dataclasses import fields
from importlib import import_module
from pathlib import Path

import cv2
import pytest
from makeup_video.pipeline import FINISHES, GraphicsParams
from makeup_video.pipeline.look import ZONES

DOCS = Path(__file__).parent.parent / "docs"
MAKERS = ("make_parameters", "make_sheets")


@pytest.fixture(autouse=True)
def _scripts_import_each_other(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))


@pytest.fixture(params=MAKERS)
def maker(request):
    return import_module(request.param)


def test_pages_are_what_the_code_writes(maker):
    page = maker.PAGE.read_text(encoding="utf-8")
    again = f"run python docs/{maker.__name__}.py"
    if maker.__name__ == "make_parameters":
        assert page == maker.text(), again
    else:  # what follows its last heading is written by people
        assert page.startswith(maker.text()), again
        assert page == maker.text() + maker.kept_judgement()


def test_every_picture_is_named_there_and_small(maker):
    named = re.findall(r"!\[[^]]*\]\(([^)]+)\)", maker.PAGE.read_text(encoding="utf-8"))
    assert sorted(named) == sorted(f"pictures/{name}" for name in maker.PICTURES)
    sizes = [(DOCS / name).stat().st_size for name in named]
    most, most_together = (150e3, 1.5e6) if maker.__name__ == "make_parameters" else (400e3, 2e6)
    assert max(sizes) < most and sum(sizes) < most_together
    assert all(cv2.imread(str(DOCS / name)) is not None for name in named)


def test_no_picture_is_left_over():
    drawn = {name for maker in MAKERS for name in import_module(maker).PICTURES}
    drawn |= set(import_module("results_pictures").GRIDS) | set(
        import_module("make_strip").PICTURES
    )
    assert {path.name for path in (DOCS / "pictures").iterdir()} <= drawn


def test_the_page_of_results_shows_its_pictures_which_are_there_and_small():
    page = DOCS / "results.md"  # measured, so it cannot be written again to compare
    if not page.exists():
        pytest.skip("nothing was measured yet")
    named = re.findall(r"!\[[^]]*\]\(([^)]+)\)", page.read_text(encoding="utf-8"))
    assert sorted(named) == sorted(f"pictures/{n}" for n in import_module("results_pictures").GRIDS)
    assert max((DOCS / name).stat().st_size for name in named) < 150e3


def test_every_parameter_zone_and_finish_is_explained():
    text = import_module("make_parameters").text()
    specs = fields(GraphicsParams)
    assert len(specs) == 17
    for spec in specs:
        assert spec.metadata["meaning"].endswith(".")
        assert f"\n### {spec.name}\n" in text
    for name in (*ZONES, *FINISHES):
        assert f"\n| `{name}` | " in text


def test_a_judgement_survives_a_new_sheet(monkeypatch, tmp_path):
    sheets = import_module("make_sheets")
    page = tmp_path / "sheets.md"
    monkeypatch.setattr(sheets, "PAGE", page)
    assert sheets.kept_judgement() == ""
    page.write_text(f"older\n\n{sheets.JUDGEMENT}\n\n* the edge\n", encoding="utf-8")
    assert sheets.kept_judgement() == "\n* the edge\n"


def test_the_readme_begins_with_the_strip():
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    (name,) = import_module("make_strip").PICTURES
    assert f"](docs/pictures/{name})" in readme
    assert (DOCS / "pictures" / name).stat().st_size < 200e3
