"""The import rules between rooms: imports run down the list, never sideways, never up."""

import ast
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

# A room imports only from lines below its own. Rooms on one line do not import each other.
TOP = (("package",), ("cli", "training"), ("benchmark",), ("web",), ("pipeline",), ("kernels",))
USED_BY_TRAINING = "pipeline", "kernels"
PIPELINE = (
    ("batch",),
    ("offline", "live", "reference"),
    ("images", "render", "smoothing"),
    ("faces", "media"),
    ("engine", "frames", "look"),
    ("files",),
    ("errors",),
)
USE_KERNELS = ("frames", "look", "media", "images", "render", "reference")
# The only places that may import a library.
ONLY_IN = {
    "pyopencl": ("kernels",),
    "onnxruntime": ("pipeline/faces/net.py", "benchmark", "training"),
    "av": (
        "pipeline/files",
        "pipeline/frames",
        "pipeline/media",
        "pipeline/live",
        "benchmark",
        "training",
    ),
    "PIL": ("pipeline/images", "pipeline/look/words.py", "web/photo_child.py", "training"),
    "simplejpeg": ("pipeline/images",),
    "pi_heif": ("pipeline/images/heif.py",),
    "typer": ("cli",),
    "rich": ("cli", "benchmark"),
    "starlette": ("web",),
    "uvicorn": ("web",),
    "cryptography": ("web/certificate.py",),
    "playwright": ("benchmark/live_browser.py",),
    "torch": ("training",),
    "ray": ("pipeline/batch/on_ray.py",),
}


@cache
def imports(folder):
    """(path, full name) of every import in a folder, at any depth of a file."""
    found = []
    for path in sorted((ROOT / folder).rglob("*.py")):
        place = path.relative_to(ROOT).as_posix()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found += [(place, alias.name) for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{place} imports relatively"
                found += [(place, f"{node.module}.{alias.name}") for alias in node.names]
    return found


def floors(lines):
    return {name: number for number, line in enumerate(lines) for name in line}


FOLDERS = tuple(floors(TOP))
ROOMS = tuple(name for name in floors(PIPELINE) if name != "errors")


@pytest.mark.parametrize("folder", FOLDERS)
def test_top_level_imports_run_down(folder):
    floor = floors(TOP)
    for place, name in imports(folder):
        if name.startswith("makeup_video.") and (other := name.split(".")[1]) != folder:
            assert other in floor, f"{place} imports {name}: name the module"
            assert floor[other] > floor[folder], f"{place} imports {name}"
            assert folder != "training" or other in USED_BY_TRAINING, f"{place} imports {name}"


@pytest.mark.parametrize("room", ROOMS)
def test_imports_in_the_pipeline_run_down(room):
    floor = floors(PIPELINE)
    for place, name in imports(f"pipeline/{room}"):
        _, *rest = name.split(".") if name.startswith("makeup_video.") else ("",)
        if rest[:1] == ["kernels"]:
            assert room in USE_KERNELS, f"{place} imports {name}"
        elif rest[:1] == ["pipeline"] and rest[1:2] != [room]:
            assert rest[1:2] and rest[1] in floor, f"{place} imports {name}: name the module"
            assert floor[rest[1]] > floor[room], f"{place} imports {name}"


def test_every_room_is_in_the_list():
    rooms = {path.parent.name for path in (ROOT / "pipeline").glob("*/*.py")}
    assert rooms == set(ROOMS)
    assert {path.name for path in (ROOT / "pipeline").glob("*.py")} == {"__init__.py", "errors.py"}


@pytest.mark.parametrize("library", ONLY_IN)
def test_a_library_stays_in_its_rooms(library):
    for folder in FOLDERS:
        for place, name in imports(folder):
            if name.split(".")[0] == library:
                assert place.startswith(ONLY_IN[library]), f"{place} imports {library}"


def test_no_private_name_crosses_a_file():
    for folder in FOLDERS:
        for place, name in imports(folder):
            if name.startswith("makeup_video."):
                assert not name.rsplit(".", 1)[1].startswith("_"), f"{place} imports {name}"
