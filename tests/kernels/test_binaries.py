"""A program that one process has built is loaded by the next, and never a damaged one."""

import hashlib

import numpy as np
import pytest
from kernel_arguments import on_device
from makeup_video.kernels import binaries, program
from makeup_video.kernels.definitions import Definitions
from makeup_video.kernels.program import Device

BYTES = np.dtype(np.uint8)
NOTHING = Definitions()
SOURCE = """
__kernel void add(__global uchar *plane) { plane[get_global_id(0)] += 3; }
"""


@pytest.fixture
def folder(monkeypatch, tmp_path):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(program, "source_of", {"add.cl": SOURCE}.__getitem__)
    return tmp_path


@pytest.fixture
def compiled(monkeypatch):
    """The sources given to PoCL, which compiles them or finds them in its own cache."""
    sources = []
    compiled = Device._compiled

    def counted(self, source, options):
        sources.append(source)
        return compiled(self, source, options)

    monkeypatch.setattr(Device, "_compiled", counted)
    return sources


def new_process():
    Device._has_saved = False


def kept(folder):
    return list(folder.glob("*.binary"))


def adds_three():
    """Whether the kernel adds three, in what counts as a new process."""
    new_process()
    device = Device()
    plane = np.arange(32, dtype=np.uint8).reshape(1, 32)
    with on_device(device, plane) as buffers:
        device.launch(device.kernel("add", 13, BYTES, NOTHING), (32, 1), buffers)
    return (plane == np.arange(3, 35)).all()


def test_what_was_built_twice_is_loaded(folder, compiled):
    assert adds_three()
    (file,) = kept(folder)
    assert file.read_bytes() == b""  # PoCL has compiled nothing more
    assert adds_three() and compiled == [SOURCE] * 2
    assert adds_three() and adds_three() and compiled == [SOURCE] * 2
    assert kept(folder) == [file]


def test_a_process_saves_one_of_its_programs(folder, compiled):
    """Saving all of them takes as long as building them the first time."""
    for saved in (0, 1, 2, 3, 3):
        new_process()
        for device, transfer in zip((Device(), Device(), Device()), (13, 16, 18), strict=True):
            device.program("add.cl", transfer, BYTES, NOTHING)
        assert sum(file.stat().st_size > 0 for file in kept(folder)) == saved
    assert len(compiled) == 3 + 3 + 2 + 1


def test_what_is_new_in_a_run_that_saves_is_known_later(folder, monkeypatch):
    said = []
    monkeypatch.setattr(Device, "on_compile", lambda: said.append(True))
    for transfers, new in (((13, 16), 2), ((13, 18), 1), ((13, 18), 0), ((13, 16, 18), 0)):
        new_process()
        said.clear()
        for transfer in transfers:
            Device().program("add.cl", transfer, BYTES, NOTHING)
        assert len(said) == new


def test_another_source_or_option_is_built_anew(folder, compiled, monkeypatch):
    assert adds_three() and adds_three()
    Device().program("add.cl", 16, BYTES, NOTHING)
    monkeypatch.setattr(program, "source_of", lambda name: SOURCE + " ")
    assert adds_three()
    assert len(compiled) == 4 and len(kept(folder)) == 3


def damaged(content):
    return content[:-1] + bytes([content[-1] ^ 1])


def cut(content):
    return content[: len(content) // 2]


def of_another_processor(content):
    """Change the number after PoCL's mark, which stands for its version and the processor."""
    changed = content[32:40] + bytes(8) + content[48:]
    return hashlib.sha256(changed).digest() + changed


def no_binary(content):
    return hashlib.sha256(b"text").digest() + b"text"


@pytest.mark.parametrize("change", [damaged, cut, of_another_processor, no_binary, lambda _: b""])
def test_a_file_that_cannot_be_used_is_replaced(folder, compiled, change):
    assert adds_three() and adds_three()
    (file,) = kept(folder)
    whole = file.read_bytes()
    file.write_bytes(change(whole))
    assert adds_three() and len(compiled) == 3
    assert adds_three() and len(compiled) == 3


def test_a_full_disk_leaves_no_part_of_a_file(folder, monkeypatch):
    def full(path, content):
        path.touch()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(binaries.Path, "write_bytes", full)
    assert adds_three() and adds_three()
    (file,) = kept(folder)
    assert file.read_bytes() == b""


def test_without_a_linker_pocl_need_not_compile_more(folder, compiled, monkeypatch):
    monkeypatch.setattr(binaries, "has_linker", lambda: False)
    assert adds_three() and adds_three()
    assert len(compiled) == 2 and [file.read_bytes() for file in kept(folder)] == [b""]


def test_other_devices_keep_their_own_programs(folder, compiled, monkeypatch):
    monkeypatch.setattr(program, "POCL", "another platform")
    Device().program("add.cl", 13, BYTES, NOTHING)
    assert len(compiled) == 1 and kept(folder) == []


def test_only_the_first_process_says_that_it_compiles(folder, compiled, monkeypatch):
    told = []
    monkeypatch.setattr(Device, "on_compile", lambda: told.append(len(compiled)))
    for _ in range(3):
        assert adds_three()
    assert told == [0]  # before the first of two builds; the second uses PoCL's cache
