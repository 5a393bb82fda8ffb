"""Generated pages match the code, and their pictures exist and are small."""

import re
import runpy
import sys
from dataclasses import fields
from importlib import import_module
from pathlib import Path

import cv2
import pytest
from makeup_video.pipeline import FINISHES, KINDS, GraphicsParams

DOCS = Path(__file__).parent.parent / "docs"
MAKERS = ("make_parameters", "make_kinds", "make_sheets", "make_ready")
# peer_mediapipe imports a library of its own environment
PROGRAMS = sorted(
    path
    for path in (DOCS / "make").glob("*.py")
    if "__main__" in path.read_text(encoding="utf-8") and path.stem != "peer_mediapipe"
)
FROM_CODE_ALONE = MAKERS[:2]  # in the other pages, people write the part after the last heading


@pytest.fixture(autouse=True)
def _scripts_import_each_other(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "make"))


@pytest.fixture(params=MAKERS)
def maker(request):
    return import_module(request.param)


def test_pages_are_what_the_code_writes(maker):
    page = maker.PAGE.read_text(encoding="utf-8")
    again = f"run python docs/make/{maker.__name__}.py"
    if maker.__name__ in FROM_CODE_ALONE:
        assert page == maker.text(), again
    else:
        assert page.startswith(maker.text()), again
        assert page == maker.text() + maker.kept_judgement()


def test_every_picture_of_a_page_is_named_and_small(maker):
    named = re.findall(r"!\[[^]]*\]\(([^)]+)\)", maker.PAGE.read_text(encoding="utf-8"))
    assert sorted(named) == sorted(f"pictures/{name}" for name in maker.PICTURES)
    sizes = [(DOCS / name).stat().st_size for name in named]
    most, most_together = (150e3, 1.5e6) if maker.__name__ == "make_parameters" else (400e3, 2e6)
    assert max(sizes) < most and sum(sizes) < most_together
    assert all(cv2.imread(str(DOCS / name)) is not None for name in named)


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_help_of_a_maker_describes_it_and_writes_nothing(program, monkeypatch, capsys):
    if program.stem == "make_results":
        pytest.importorskip("torch")  # of the extra `train`

    def refused(path, *_args, **_options):
        raise AssertionError(f"{path} would be written")

    monkeypatch.setattr(sys, "argv", [program.name, "--help"])
    monkeypatch.setattr(Path, "write_text", refused)
    monkeypatch.setattr(cv2, "imwrite", refused)
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(program), run_name="__main__")
    _, *described = capsys.readouterr().out.split("\n\n")
    assert ended.value.code == 0 and len(described[0]) > 30


def test_no_picture_is_without_a_page():
    drawn = {name for maker in MAKERS for name in import_module(maker).PICTURES}
    drawn |= set(import_module("results_pictures").GRIDS) | set(
        import_module("make_strip").PICTURES
    )
    drawn |= set(import_module("performance_page").PICTURES)
    drawn |= set(import_module("make_live_picture").PICTURES)
    assert {path.name for path in (DOCS / "pictures").iterdir()} <= drawn


def test_the_results_page_shows_all_of_its_small_pictures():
    page = DOCS / "results.md"  # contains measurements, so a second run would differ
    if not page.exists():
        pytest.skip("nothing was measured yet")
    named = re.findall(r"!\[[^]]*\]\(([^)]+)\)", page.read_text(encoding="utf-8"))
    assert sorted(named) == sorted(f"pictures/{n}" for n in import_module("results_pictures").GRIDS)
    assert max((DOCS / name).stat().st_size for name in named) < 150e3


def test_every_parameter_and_finish_is_explained():
    text = import_module("make_parameters").text()
    specs = fields(GraphicsParams)
    assert len(specs) == 17
    for spec in specs:
        assert spec.metadata["meaning"].endswith(".")
        assert f"\n### {spec.name}\n" in text
    for name in FINISHES:
        assert f"\n| `{name}` | " in text


def test_every_kind_number_and_slot_is_explained():
    text = import_module("make_kinds").text()
    for kind in KINDS.values():
        assert f"\n## {kind.product}\n" in text and f"`--{kind.part} " in text
        for dial in kind.dials:
            assert f"\n| `{dial.name}` | " in text and dial.meaning in text
        for slot in kind.slots:
            assert f"\n| `{slot}` | " in text


def test_a_written_judgement_survives_a_new_sheet(monkeypatch, tmp_path):
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


def measured():
    """Results as from the bench, for one size and one round."""
    runs = {"fps": 100.0, "fps_spread": [99.0, 101.0], "cpu_ms_per_frame": 12.0}
    beside = {"ratio": 0.5, "ratio_spread": [0.4, 0.6], "not_codec_cpu_ms": 6.0}
    times = {"mean_ms": 2.0, "p50_ms": 1.0, "p95_ms": 3.0, "cpu_mean_ms": 1.0, "cpu_p50_ms": 1.0}
    ours = {**runs, **beside}
    size = {
        "film": "1280x720", "bare": {**runs, "threads": [0, 0]},
        "codec": {**runs, "threads": [1, 2]}, "none": ours, "product": ours,
        "default_times_real_time": 3.0, "painted_share": 1.0, "start_seconds": 1.0,
        "first_start_seconds": 2.0, "peak_memory_mb": 300.0, "bottleneck": "encode",
        "stages": {"decode": times, "encode": times},
        "channels": {"-> encode": {"capacity": 2, "mean_fill": 0.5}},
    }  # fmt: skip
    long = {"minutes": 1.0, "frames": 1800, "fps": 90.0, "peak_memory_mb": 250.0, "growth": 1.0,
            "memory": [[0.1, 100.0], [1.0, 250.0]]}  # fmt: skip
    rows = {"360p": {"px": 230400, "bare": runs, "product": ours},
            "720p": {"px": 921600, "bare": runs, "product": ours}}  # fmt: skip
    clip = {"clip": "in.mp4", "codec": "libx264", "rounds": 1, "sizes": {"720p": size}}
    return {
        "whole": {"in.mp4": clip},
        "resolution": {"heights": rows},
        "faces": {"height_px": 720, "further_face_cpu_ms": 2.0, "counts": {"1": ours, "2": ours}},
        "threads": {"size": "720p", "best": "auto", "settings": {"auto": runs}},
        "length": [long, {**long, "minutes": 10.0}],
        "peer": "| bare | 1.0 |",
    }


def test_measured_numbers_fill_the_page_of_measurements(tmp_path):
    pytest.importorskip("matplotlib")
    performance = import_module("performance_page")
    page, before = tmp_path / "page.md", performance.PAGE.read_text(encoding="utf-8")
    page.write_text(before, encoding="utf-8")
    performance.write_page(measured(), page, tmp_path)
    text = page.read_text(encoding="utf-8")
    assert "| whole product / bare, frames/s | 0.5 (>= 0.78: missed) |" in text
    assert "| times real time, default preset | 3 (>= 2.5) |" in text
    shown = re.findall(r"!\[[^]]*\]\(pictures/([^)]+)\)", text)
    assert sorted(shown) == sorted(performance.PICTURES)
    assert all(0 < (tmp_path / name).stat().st_size < 60e3 for name in shown)
    blocks = re.compile(r"(<!-- measured: \w+ -->\n).*?(<!-- end -->)", re.DOTALL)
    assert blocks.sub(r"\1\2", text) == blocks.sub(r"\1\2", before)  # hand-written text stays
    performance.write_page({"faces": measured()["faces"]}, page, tmp_path)
    assert page.read_text(encoding="utf-8") == text


def test_a_missing_marker_is_named():
    between = import_module("performance_page").between_markers
    with pytest.raises(ValueError, match="measured: faces"):
        between("<!-- measured: whole -->\n<!-- end -->", "faces", "x")


def test_the_page_of_measurements_shows_the_existing_pictures():
    performance = import_module("performance_page")
    text = performance.PAGE.read_text(encoding="utf-8")
    named = set(re.findall(r"\]\(pictures/([^)]+)\)", text))
    there = {name for name in performance.PICTURES if (performance.FOLDER / name).exists()}
    assert named == there
    assert all((performance.FOLDER / name).stat().st_size < 60e3 for name in there)


def test_the_summary_of_performance_repeats_measured_figures():
    """Every fraction in a summary table whose section names its run stands in the full tables."""
    measured_text = import_module("performance_page").PAGE.read_text(encoding="utf-8")
    figures = set(re.findall(r"\d+\.\d+", measured_text))
    sections = (DOCS / "performance.md").read_text(encoding="utf-8").split("\n## ")
    repeated = [text for text in sections if "(measurements.md#" in text]
    assert len(repeated) >= 8
    for text in repeated:
        rows = "\n".join(line for line in text.splitlines() if line.startswith("|"))
        assert set(re.findall(r"\d+\.\d+", rows)) <= figures, text.splitlines()[0]


def prose_lines(path):
    """Number and text of the lines outside tables, pictures and code."""
    fenced = False
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        fence = line.startswith("```")
        fenced ^= fence
        if not (fence or fenced or line.startswith(("|", "![", "    "))):
            yield number, line


def test_lines_of_prose_are_short():
    root = DOCS.parent
    pages = [root / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md")]
    pages += [root / "samples" / "README.md", *sorted(DOCS.rglob("*.md"))]
    too_long = [
        f"{page.relative_to(root)}:{number} has {len(line)} characters, expected at most 110"
        for page in pages
        for number, line in prose_lines(page)
        if len(line) > 110
    ]
    assert not too_long
