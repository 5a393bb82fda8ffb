"""The real command with too little memory or disk, and with files that make C libraries print."""

import os
import resource
import struct
import subprocess
import sys
import zlib

import cv2
import numpy as np
import pytest
from people import SAMPLES
from PIL import Image

PICTURE = [str(SAMPLES / "portrait.jpg"), "--color", "B4002E", "-o", "out.jpg"]
VIDEO = [str(SAMPLES / "in.mp4"), "--color", "B4002E", "-o", "out.mp4", "--end", "0.5"]
COPY = [str(SAMPLES / "in.mp4"), "--look", "none", "-o", "out.mp4", "--end", "0.5"]
ESTIMATE = ["estimate", str(SAMPLES / "look.jpg")]
INSPECT = ["inspect", str(SAMPLES / "in.mp4"), "-o", "out.mp4", "--end", "0.5"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(words, limit=None, **environment):
    """Exit code and the lines on stderr; limit: (resource, bytes)."""

    def limited():
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if limit:
            resource.setrlimit(limit[0], (limit[1], limit[1]))

    done = subprocess.run(
        [sys.executable, "-m", "makeup_video.cli", *words],
        env={**os.environ, **environment},
        preexec_fn=limited,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    return done.returncode, done.stderr.splitlines()


@pytest.mark.parametrize("megabytes", [200, 450, 620, 800])
@pytest.mark.parametrize("words", [PICTURE, VIDEO, ESTIMATE, INSPECT], ids=lambda words: words[0])
def test_too_little_address_space_is_one_line(folder, words, megabytes):
    code, lines = run(words, (resource.RLIMIT_AS, megabytes << 20))
    assert code == 1 and len(lines) == 1, lines
    assert lines[0].startswith("TooLittleMemoryError: ") and "limit" in lines[0]
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(("words", "megabytes"), [(VIDEO, 1100), (ESTIMATE, 1000), (COPY, 350)])
def test_the_line_names_the_figure_that_is_needed(words, megabytes):
    code, lines = run(words, (resource.RLIMIT_AS, megabytes << 20))
    assert code == 1 and len(lines) == 1
    assert "MB of address space, and this process may take" in lines[0] and "ulimit -v" in lines[0]


def test_no_room_for_kernels_is_one_line(folder):
    """A limit on file sizes stands in for a full disk, on which PoCL and LLVM end the process."""
    limit = (resource.RLIMIT_FSIZE, 100_000)
    code, lines = run(PICTURE, limit, POCL_CACHE_DIR=str(folder / "kernels"), TMPDIR=str(folder))
    assert code == 4 and len(lines) == 1, lines
    assert lines[0].startswith(
        "OutputError: the kernels that paint need a folder with 8 MB of room"
    )
    assert [path.name for path in folder.iterdir()] == ["kernels"]


BATCH = ["batch", str(SAMPLES / "portrait.jpg"), "--color", "B4002E", "-o", "{name}.out.jpg"]
LIVE = ["live", "--camera", str(SAMPLES / "in.mp4"), "--look", "none", "--no-preview",
        "-o", "out.mkv", "--color", "B4002E"]  # fmt: skip


@pytest.mark.parametrize("words", [PICTURE, BATCH, LIVE], ids=["apply", "batch", "live"])
def test_kernels_that_are_lost_after_the_run_have_a_line(folder, words):
    (folder / "file").touch()
    code, lines = run(words, POCL_CACHE_DIR=str(folder / "file" / "below"))
    (lost,) = [line for line in lines if "cannot be kept" in line]
    reason = f"({folder}/file/below: Not a directory)"
    assert code == 0 and f"{reason}: set POCL_CACHE_DIR to a folder that stays" in lost


def test_a_copy_and_a_quiet_run_say_nothing_about_kernels(folder):
    (folder / "file").touch()
    nowhere = str(folder / "file" / "below")
    assert run([*PICTURE, "--quiet"], POCL_CACHE_DIR=nowhere) == (0, [])
    code, lines = run(COPY, POCL_CACHE_DIR=nowhere)
    assert code == 0 and not [line for line in lines if "cannot be kept" in line]


def test_a_kernel_folder_is_removed_also_after_ctrl_c(folder):
    (folder / "file").touch()
    code = (
        "import os, signal; from makeup_video.cli import main\n"
        "from makeup_video.kernels import cache\n"
        "cache.settle(); assert os.path.isdir(os.environ['POCL_CACHE_DIR']); main._exit(130)"
    )
    environment = {**os.environ, "POCL_CACHE_DIR": str(folder / "file"), "TMPDIR": str(folder)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, check=False)
    assert done.returncode == 130
    assert [path.name for path in folder.iterdir()] == ["file"]


def png_with(chunk, data):
    """A PNG with an extra chunk after its header."""
    whole = cv2.imencode(".png", np.full((32, 32, 3), 90, np.uint8))[1].tobytes()
    more = struct.pack(">I", len(data)) + chunk + data
    return whole[:33] + more + struct.pack(">I", zlib.crc32(chunk + data)) + whole[33:]


def disturbed(suffix):
    """A picture file of this type with noise in the middle of its data."""
    noise = np.random.default_rng(5).integers(0, 256, (64, 64, 3)).astype(np.uint8)
    name = f"disturbed{suffix}"
    Image.fromarray(noise).save(
        name, **({"compression": "tiff_lzw"} if suffix == ".tif" else {"quality": 90})
    )
    with open(name, "r+b") as file:
        file.seek(os.path.getsize(name) // 2)
        file.write(bytes(range(200, 0, -3)))
    return name


@pytest.mark.parametrize(
    ("chunk", "data"),
    [(b"iCCP", b"bad\0\0" + zlib.compress(bytes(200))), (b"tIME", b"\0"), (b"zTXt", b"\0")],
)
@pytest.mark.parametrize("before", [[], ["inspect"]])
def test_libpng_prints_nothing(folder, chunk, data, before):
    (folder / "odd.png").write_bytes(png_with(chunk, data))
    words = [*before, "odd.png", *([] if before else ["--look", "none"]), "-o", "out.png"]
    code, lines = run(words)
    assert code == 0 and not any("libpng" in line for line in lines)
    assert lines[-1].startswith("out.png: one picture")


def test_libjpeg_and_libtiff_print_nothing(folder):
    code, lines = run([disturbed(".jpg"), "--look", "none", "-o", "out.png"])
    assert len(lines) == 1 and lines[0].startswith(
        "out.png: one picture" if code == 0 else "Decode"
    )
    tiff = disturbed(".tif")
    for words in (["estimate", tiff], [*PICTURE[:1], "--ref", tiff, "-o", "out2.jpg"]):
        code, lines = run(words)
        assert code == 3 and len(lines) == 1 and lines[0].startswith("PhotoError: "), lines


def test_debug_shows_what_libraries_print(folder):
    (folder / "odd.png").write_bytes(png_with(b"tIME", b"\0"))
    _, lines = run(["odd.png", "--look", "none", "-o", "out.png", "--debug"])
    assert "libpng warning: tIME: too short" in lines


def test_onnx_runtime_stores_nothing_and_sends_nothing(folder):
    code = (
        "import os; import makeup_video.pipeline.faces.net\n"
        "print(os.environ['ORT_DISABLE_TELEMETRY'])"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache"), "HOME": str(folder)}
    environment.pop("ORT_DISABLE_TELEMETRY", None)
    output = subprocess.check_output([sys.executable, "-c", code], env=environment, text=True)
    assert output == "1\n" and list(folder.rglob("*onnxruntime*")) == []
