"""The benchmark uses settings and observers: no file of the wheel uses mocks."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SHIPPED = ("benchmark", "cli", "kernels", "package", "pipeline", "training", "web")


@pytest.mark.parametrize("folder", SHIPPED)
def test_no_file_of_the_wheel_imports_unittest(folder):
    files = sorted((ROOT / folder).rglob("*.py"))
    assert files
    for path in files:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.split(".")[0] == "unittest" for name in names), path
