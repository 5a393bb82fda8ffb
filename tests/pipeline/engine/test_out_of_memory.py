"""Errors of exhausted memory are recognised without loading any more modules."""

import ast
from pathlib import Path

import pytest
from makeup_video.pipeline.engine import out_of_memory
from makeup_video.pipeline.engine.out_of_memory import is_out_of_memory


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (MemoryError(), True),
        (RuntimeError("can't start new thread"), True),
        (ImportError("libx.so: failed to map segment from shared object"), True),
        (RuntimeError("clCreateBuffer failed: MEM_OBJECT_ALLOCATION_FAILURE"), True),
        (OSError(12, "Cannot allocate memory"), True),
        (RuntimeError("clBuildProgram failed: BUILD_PROGRAM_FAILURE"), False),
        (ValueError("memory"), False),
    ],
)
def test_errors_of_memory_are_known_by_type_or_words(error, expected):
    assert is_out_of_memory(error) == expected


def test_the_module_loads_nothing():
    tree = ast.parse(Path(out_of_memory.__file__).read_text(encoding="utf-8"))
    assert not [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]


def test_the_command_loads_it_before_its_options():
    main = Path(__file__).parents[3] / "cli" / "main.py"
    names = [
        node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
        for node in ast.walk(ast.parse(main.read_text(encoding="utf-8")))
        if isinstance(node, ast.Import | ast.ImportFrom)
    ]
    assert names.index(out_of_memory.__name__) < names.index("makeup_video.cli.app")
