"""Makes docs/python.ipynb from docs/python.md: text and cells of code, without outputs.

    python docs/make/make_notebook.py

A link to another page leads to the page beside the notebook, as in python.md.
"""

import argparse
import json
import re
from pathlib import Path

PAGE = Path(__file__).parents[1] / "python.md"
NOTEBOOK = PAGE.with_suffix(".ipynb")
_CODE = re.compile(r"^```python\n(.*?)^```\n", re.DOTALL | re.MULTILINE)
_OF_NOTEBOOK = re.compile(r"^The same page as a notebook:.*?\n\n", re.DOTALL | re.MULTILINE)
_SETUP = """\
Run the cells from top to bottom, in the root of a clone of makeup-video with the samples:
`pip install -q . tqdm jupyterlab && jupyter lab docs/python.ipynb`
"""
_TO_ROOT = """\
import os
from pathlib import Path

if not Path("samples").exists():
    os.chdir("..")  # a notebook begins in its own folder
"""


def code_cells() -> list[str]:
    """The code of the page, block by block."""
    return _CODE.findall(PAGE.read_text(encoding="utf-8"))


def without_notebook(page: str) -> str:
    """Leave out the paragraph that leads to the notebook. Raises ValueError where there is none."""
    text, count = _OF_NOTEBOOK.subn("", page)
    if count != 1:
        raise ValueError(
            f'{PAGE.name} must have one paragraph that begins "The same page as a notebook:", '
            f"got {count}"
        )
    return text


def cells() -> list[dict[str, object]]:
    """The cells of the notebook."""
    title, text = without_notebook(PAGE.read_text(encoding="utf-8")).split("\n", 1)
    made = [_cell("markdown", f"{title}\n\n{_SETUP}"), _cell("code", _TO_ROOT)]
    for number, part in enumerate(_CODE.split(text)):
        if part.strip():
            made.append(_cell("code" if number % 2 else "markdown", part.strip("\n") + "\n"))
    return [{**cell, "id": f"cell-{number}"} for number, cell in enumerate(made)]


def _cell(kind: str, text: str) -> dict[str, object]:
    lines = text.removesuffix("\n").splitlines(keepends=True)
    more = {"execution_count": None, "outputs": []} if kind == "code" else {}
    return {"cell_type": kind, "metadata": {}, "source": lines, **more}


def text() -> str:
    """The notebook, in nbformat 4.5."""
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {
        "cells": cells(),
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    NOTEBOOK.write_text(text(), encoding="utf-8")
