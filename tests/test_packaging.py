"""The shipped package: every folder and file is listed, and the README is right."""

import ast
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import requires
from pathlib import Path

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
FOLDERS = PROJECT["tool"]["setuptools"]["package-dir"]
TYPED = ("pipeline", "kernels", "web", "benchmark", "cli")


def sources(folder):
    return sorted((ROOT / folder).rglob("*.py"))


def imported(path):
    """Names of every module that a file imports, at any depth."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield "." * node.level + (node.module or "")


def test_every_folder_with_code_is_a_package_and_listed():
    listed = PROJECT["tool"]["setuptools"]["packages"]
    tops = {name.split("/")[0] for name in FOLDERS.values()}
    found = {path.parent.relative_to(ROOT).as_posix() for top in tops for path in sources(top)}
    assert found == set(FOLDERS.values())
    assert all((ROOT / name / "__init__.py").exists() for name in found)
    others = {path.parent.name for path in ROOT.glob("*/__init__.py")} - tops
    assert others <= {"tests"}
    names = {f"makeup_video.{name.replace('/', '.')}" for name in found - {"package"}}
    assert set(FOLDERS) == set(listed) == names | {"makeup_video"}
    assert (ROOT / "package" / "py.typed").exists()


def test_only_the_listed_modules_use_threads():
    users = {
        path.relative_to(ROOT / "pipeline").as_posix()
        for path in sources("pipeline")
        if {"threading", "concurrent.futures"} & set(imported(path))
    }
    assert users == {
        "batch/on_ray.py",  # reports while it paints; a lock for files that were sent
        "engine/fan_out.py",
        "engine/jobs.py",  # each thread waits for a process that paints
        "images/quiet.py",  # a lock: the last block that ends restores a setting
        "engine/machine.py",  # a lock for the number of OpenCV's threads
        "engine/processes.py",  # ends with the process that started it
        "engine/runner.py",
        "engine/signals.py",  # only the main thread may set handlers
        "engine/channel.py",  # its lock
        "render/apply_look.py",  # keeps the kernels of each thread
        "live/runner.py",
        "offline/looks_on_picture.py",  # paints several looks at once
        "offline/painter.py",  # a lock: one thread at a time
        "live/sources/device.py",  # reads the camera even when nobody fetches frames
        "live/sources/file.py",  # an event that ends a wait
        "live/sources/file_sound.py",  # the same
        "live/sources/switch.py",  # waits for a camera that is being exchanged
        "live/sound.py",  # reads the microphone while pictures are painted
        "media/input_file.py",  # a lock: FFmpeg has one level of log for all
        "media/mux.py",  # the file's lock
        "reference/cheeks.py",  # a lock: one thread at a time
        "reference/nets.py",  # loads nets while the photo is decoded
    }


def test_only_the_promised_libraries_are_required():
    needed = {re.split(r"[<>=; \[]", text)[0] for text in requires("makeup-video") or []
              if "extra ==" not in text}  # fmt: skip
    assert needed == {
        "av", "numpy", "opencv-contrib-python-headless", "onnxruntime", "pillow", "pyopencl",
        "pocl-binary-distribution", "rich", "simplejpeg", "pi-heif", "starlette", "typer", "uvicorn", "websockets",
    }  # fmt: skip


def test_no_file_refers_to_the_folder_above_the_repository():
    for path in ROOT.glob("*/**/*.py"):
        if ".venv" not in path.parts and path != Path(__file__):
            assert "../" not in path.read_text(), path


def test_files_and_functions_stay_short_enough_to_read():
    for folder in TYPED:
        for path in sources(folder):
            text = path.read_text()
            assert len(text.splitlines()) <= 400, path
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.FunctionDef):
                    lines = node.end_lineno - node.body[0].lineno + 1
                    assert lines <= 50, f"{path.name}: {node.name} has {lines} lines"


def test_the_public_names_are_complete_and_sorted():
    import makeup_video.pipeline as public

    constants_first = sorted(public.__all__, key=lambda name: (not name.isupper(), name))
    assert list(public.__all__) == constants_first
    assert all(hasattr(public, name) for name in public.__all__)


def test_names_are_there_from_the_first_use_on_and_stay():
    code = (
        "import makeup_video as m\n"
        "assert 'Look' in dir(m.pipeline) and m.Look is m.pipeline.Look\n"
        "from makeup_video.pipeline.engine import machine\n"
        "machine.check_memory = None\n"
        "assert m.Look and m.pipeline.Look"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_readme_begins_with_the_two_commands():
    blocks = re.findall(r"```(?:sh)?\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert "out.mp4" in blocks[0] and "samples/in.mp4" in blocks[0]
    assert "pytest" in blocks[1]


def test_the_sample_media_are_there_and_small():
    for name, limit in (("in.mp4", 4e6), ("portrait.jpg", 5e5), ("in_points.npz", 1e6)):
        assert 0 < (ROOT / "samples" / name).stat().st_size < limit


def test_the_wheel_carries_every_source_file(tmp_path):
    copy = tmp_path / "copy"  # a build leaves files behind, and must not include old ones
    for name in (*FOLDERS.values(), "pyproject.toml", "README.md", "LICENSE"):
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, copy / name, dirs_exist_ok=True)
        else:
            shutil.copy(ROOT / name, copy / name)
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "-q"]
    subprocess.run([*command, "-w", str(tmp_path), str(copy)], check=True, capture_output=True)
    names = set(zipfile.ZipFile(next(tmp_path.glob("*.whl"))).namelist())
    for package, folder in FOLDERS.items():
        assert list((ROOT / folder).glob("*.py")), folder
        place = package.replace(".", "/")
        for path in (ROOT / folder).iterdir():
            kept = (".py", ".cl", ".h", ".onnx", ".json", ".csv")
            if path.suffix in kept or path.name == "py.typed":
                assert f"{place}/{path.name}" in names
    for folder in ("pipeline/weights", "web/page"):
        for path in (ROOT / folder).iterdir():
            assert f"makeup_video/{folder}/{path.name}" in names
    for name in (
        "faces/lip_contours.json",
        "faces/shut_eyes.csv",
        "worn/liners.csv",
        "worn/lipsticks.csv",
    ):
        assert f"makeup_video/training/{name}" in names


def test_test_files_and_names_stay_short_enough_to_read():
    for path in sorted((ROOT / "tests").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        assert len(text.splitlines()) <= 350, path
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                assert len(node.name) <= 57, f"{path.name}: {node.name}"
