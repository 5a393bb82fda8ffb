"""The notebook is the page docs/python.md, its cells run, and type checkers understand them."""

import json
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture
def notebook(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "make"))
    return import_module("make_notebook")


def test_the_notebook_is_what_the_page_says(notebook):
    again = "run python docs/make/make_notebook.py"
    assert notebook.NOTEBOOK.read_text(encoding="utf-8") == notebook.text(), again


def test_the_notebook_and_the_site_do_not_lead_to_it(notebook):
    page = SimpleNamespace(file=SimpleNamespace(src_uri="python.md"))
    hooks = import_module("site_hooks")
    on_site = hooks.on_page_markdown(notebook.PAGE.read_text(encoding="utf-8"), page)
    for text in (notebook.text(), on_site):
        assert "ipynb](" not in text and "as a notebook" not in text
    with pytest.raises(ValueError, match=r"one paragraph that begins .* got 0"):
        notebook.without_notebook(on_site)


@pytest.mark.timeout(600)
def test_the_cells_run_from_top_to_bottom(notebook, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "samples", tmp_path / "samples")
    monkeypatch.chdir(tmp_path)
    cells = json.loads(notebook.NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert len(code) == len(notebook.code_cells()) + 1  # and the cell that finds the samples
    names = {"__name__": "notebook"}
    for number, source in enumerate(code):
        exec(compile(source, f"cell {number}", "exec"), names)  # noqa: S102
    written = {"out.mp4", "out.mkv", "a.mp4", "b.mp4", "seen.png", "painted.png", "look.json"}
    assert written <= {path.name for path in tmp_path.iterdir()}
    assert names["painter"].painted_frames == 30 and not names["look"].is_bare


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_type_checkers_understand_the_cells(notebook, tmp_path):
    pytest.importorskip("mypy")
    links = ROOT / ".typing"
    if not links.exists():
        pytest.skip("run .ci/typing_links first")
    script = tmp_path / "cells.py"
    script.write_text("\n".join(notebook.code_cells()), encoding="utf-8")
    wrong = tmp_path / "wrong.py"
    wrong.write_text("from makeup_video import Painter, nonsense\nPainter({})\n", encoding="utf-8")
    config = tmp_path / "mypy.ini"
    config.write_text(
        f"[mypy]\nmypy_path = {links}\nnamespace_packages = true\nexplicit_package_bases = true\n"
        "follow_imports = silent\ncheck_untyped_defs = true\ndisable_error_code = import-untyped\n"
    )
    command = [sys.executable, "-m", "mypy", "--config-file", str(config)]
    command += ["--cache-dir", str(ROOT / ".mypy_cache" / "cells")]
    right = subprocess.run([*command, str(script)], capture_output=True, text=True, check=False)
    assert right.returncode == 0, right.stdout
    checked = subprocess.run([*command, str(wrong)], capture_output=True, text=True, check=False)
    refused = checked.stdout
    assert 'has no attribute "nonsense"' in refused and 'expected "Look"' in refused
