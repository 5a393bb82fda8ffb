"""Hooks of mkdocs.yml: where the site differs from the pages in the repository."""

import re
from typing import Any

# The notebook is for Jupyter, and no page of the site.
_NOTEBOOK = re.compile(r"^The same page as a notebook:.*?\n\n", re.DOTALL | re.MULTILINE)


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Leave out the link to the notebook."""
    return _NOTEBOOK.sub("", markdown) if page.file.src_uri == "python.md" else markdown
