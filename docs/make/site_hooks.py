"""Hooks of mkdocs.yml: where the site differs from the pages in the repository."""

from typing import Any

from make_notebook import without_notebook  # MkDocs looks for it beside this file


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Leave out the link to the notebook, which is made for Jupyter and is not on the site."""
    return without_notebook(markdown) if page.file.src_uri == "python.md" else markdown
