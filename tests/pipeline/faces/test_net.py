"""Weights are verified against their hashes before use."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from makeup_video.pipeline import InstallError
from makeup_video.pipeline.faces import net
from makeup_video.pipeline.faces.topology import (
    EYE,
    EYE_CONTOUR,
    LIPS,
    LIPS_INNER,
    LIPS_OUTER,
    RIGHT_EYE,
)

SMALL = np.random.default_rng(0).integers(0, 256, (1, 192, 320, 3), np.uint8)
LARGE = np.zeros((1, 768, 1024, 3), np.uint8)


@pytest.fixture
def folder(tmp_path):
    """A copy of the weights that a test may damage."""
    for file in net.SHIPPED.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    return tmp_path


def test_weights_are_small_and_every_one_has_a_hash():
    files = {file.name: file.read_bytes() for file in net.SHIPPED.iterdir()}
    hashes = json.loads(files.pop("sha256.json"))
    assert set(hashes) == set(files)
    read_once = {name for name in files if name.startswith("reference_")}
    assert sum(len(data) for name, data in files.items() if name not in read_once) <= 8e6
    assert sum(map(len, files.values())) <= 24e6  # installed size, bytes


@pytest.mark.parametrize("name", ["detector.onnx", "mesh.onnx", "lips.onnx", "eye.onnx",
                                  "mean_face.npy", "mirror.npy"])  # fmt: skip
def test_one_changed_byte_is_refused_by_name(folder, name):
    data = bytearray((folder / name).read_bytes())
    data[len(data) // 2] ^= 1
    (folder / name).write_bytes(data)
    with pytest.raises(InstallError, match=rf"{name} .*install makeup-video again") as error:
        net.read(name, folder)
    assert "\n" not in str(error.value)


def test_missing_weights_are_refused_in_one_line(folder):
    (folder / "mesh.onnx").unlink()
    with pytest.raises(InstallError, match=r"mesh\.onnx are missing"):
        net.Net("mesh", folder)


@pytest.mark.parametrize("text", ["[]", "null", "1", '"mesh.onnx"', "{}", "{", ""])
def test_a_broken_list_of_hashes_is_refused_in_one_line(folder, text):
    (folder / "sha256.json").write_text(text)
    with pytest.raises(InstallError, match=r"mesh\.onnx are missing") as error:
        net.read("mesh.onnx", folder)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "crop", "shapes"),
    [
        ("mesh", (96, 96), {"points": (478, 3), "scores": (2,)}),
        ("lips", (80, 112), {"points": (80, 3), "mask_logits": (80, 112)}),
        ("eye", (48, 64), {"points": (53, 3)}),
        ("detector", (160, 256), {"cells": (6, 20, 32)}),
    ],
)
@pytest.mark.parametrize("count", [1, 2])
def test_every_net_takes_crops_and_gives_finite_numbers(name, crop, shapes, count):
    rng = np.random.default_rng(0)
    rgb8 = rng.integers(0, 256, (count, *crop, 3), dtype=np.uint8)
    out = net.Net(name)(rgb8)
    for key, shape in shapes.items():
        assert out[key].shape == (count, *shape)
        assert out[key].dtype == np.float32
        assert np.isfinite(out[key]).all()


def test_a_net_repeats_its_answer_on_any_number_of_threads():
    rgb8 = np.random.default_rng(1).integers(0, 256, (1, 96, 96, 3), dtype=np.uint8)
    mesh = net.Net("mesh")
    first = mesh(rgb8)["points"]
    assert (mesh(rgb8)["points"] == first).all()
    assert net.Net("mesh", threads=2)(rgb8)["points"] == pytest.approx(first, abs=1e-5)


def test_the_mirror_is_its_own_inverse_and_maps_lips_to_lips():
    mirror = net.read_array("mirror.npy").astype(int)
    assert (mirror[mirror] == np.arange(478)).all()
    for index in (LIPS, LIPS_OUTER, LIPS_INNER):
        assert set(mirror[index]) == set(index.tolist())
    assert (mirror[EYE] == RIGHT_EYE).all()


def test_the_mean_faces_eye_corners_are_level_and_one_apart():
    mean = net.read_array("mean_face.npy")
    left, right = mean[33], mean[263]
    assert right - left == pytest.approx([1, 0, 0], abs=0.02)
    assert (mean[EYE_CONTOUR, 0] < 0).all()


def test_nets_keep_no_arena_of_memory_between_their_runs():
    ours = net.Net("eye")
    assert not ours._session.get_session_options().enable_cpu_mem_arena


def test_an_arena_changes_no_number():
    plain, kept = net.Net("detector"), net.Net("detector", has_arena=True)
    for picture in (SMALL, LARGE, SMALL):
        assert np.array_equal(plain(picture)["cells"], kept(picture)["cells"])


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the system hides its memory")
def test_an_arena_keeps_no_large_input():
    # in a process of its own: what is freed in a long run may stay in the heap
    held = """
from pathlib import Path
import numpy as np
from makeup_video.pipeline.faces.net import Net
pages = lambda: int(Path("/proc/self/statm").read_text().split()[1])
kept = Net("detector", has_arena=True)
kept(np.zeros((1, 192, 320, 3), np.uint8))
before = pages()
kept(np.zeros((1, 768, 1024, 3), np.uint8))
print((pages() - before) * 4096)
"""
    done = subprocess.run([sys.executable, "-c", held], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 15e6
