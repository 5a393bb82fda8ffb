"""Memory limits are read where the system keeps them; a job that needs more is refused."""

import resource

import pytest
from makeup_video.pipeline import MakeupVideoError
from makeup_video.pipeline.engine import machine
from makeup_video.pipeline.engine.machine import (
    COPY_VIDEO,
    FIND_FACES,
    PAINT_PICTURE,
    PAINT_VIDEO,
    READ_PHOTO,
    SHOW_VIDEO,
    check_memory,
    group_limit_bytes,
    peak_memory_bytes,
)
from makeup_video.pipeline.errors import TooLittleMemoryError

NEEDS = [COPY_VIDEO, FIND_FACES, PAINT_PICTURE, PAINT_VIDEO, READ_PHOTO, SHOW_VIDEO]


@pytest.fixture
def system(monkeypatch, tmp_path):
    """system(groups, swap_kb, **limits) writes files like those in /proc and /sys/fs/cgroup."""

    def write(groups, swap_kb=0, **limits):
        (tmp_path / "proc/self").mkdir(parents=True)
        (tmp_path / "proc/self/cgroup").write_text(groups)
        (tmp_path / "proc/meminfo").write_text(f"MemTotal: 9 kB\nSwapTotal:   {swap_kb} kB\n")
        for path, text in limits.items():
            file = tmp_path / "groups" / path.replace("__", "/").replace("memory_", "memory.")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text + "\n")

    monkeypatch.setattr(machine, "_PROC", tmp_path / "proc")
    monkeypatch.setattr(machine, "_GROUPS", tmp_path / "groups")
    monkeypatch.setattr(machine, "cores", lambda: 2)
    return write


def allow(monkeypatch, limit):
    monkeypatch.setattr(resource, "getrlimit", lambda which: (limit, limit))


@pytest.mark.parametrize("need", NEEDS, ids=lambda need: need.name)
def test_a_low_address_limit_is_shown_with_both_figures(monkeypatch, system, need):
    system("")
    allow(monkeypatch, 123_000_000)
    with pytest.raises(TooLittleMemoryError) as caught:
        check_memory(need, 1280 * 720)
    message = str(caught.value)
    assert message.startswith(need.name) and "\n" not in message
    assert "may take 123 MB (ulimit -v)" in message
    assert isinstance(caught.value, MakeupVideoError | MemoryError) and caught.value.exit_code == 1
    allow(monkeypatch, resource.RLIM_INFINITY)
    check_memory(need, 1280 * 720)


def test_larger_frames_need_more(monkeypatch, system):
    system("")
    allow(monkeypatch, 1_600_000_000)
    check_memory(PAINT_VIDEO, 1280 * 720)
    with pytest.raises(TooLittleMemoryError):
        check_memory(PAINT_VIDEO, 3840 * 2160)


@pytest.mark.parametrize(
    ("groups", "limits", "least"),
    [
        ("0::/a/b\n", {"a__b__memory_max": "50000000"}, 50_000_000),
        ("0::/a/b\n", {"a__b__memory_max": "max", "a__memory_max": "70000000"}, 70_000_000),
        ("0::/a/b\n", {"a__b__memory_max": "max"}, None),
        # a container sees only its own root
        ("0::/gone\n", {"memory_max": "60000000"}, 60_000_000),
        ("4:cpu,memory:/a\n0::/\n", {"memory__a__memory_limit_in_bytes": "40000000"}, 40_000_000),
        ("4:memory:/a\n", {"memory__memory_limit_in_bytes": "9223372036854771712"}, 2**63 - 4096),
        ("3:cpu:/a\n", {}, None),
    ],
)
def test_the_limit_of_a_group_is_the_least_of_those_above(system, groups, limits, least):
    system(groups, **limits)
    assert group_limit_bytes() == least


def test_a_control_group_that_cannot_hold_the_job_is_named(monkeypatch, system):
    system("0::/\n", memory_max="60000000")
    allow(monkeypatch, resource.RLIM_INFINITY)
    check_memory(COPY_VIDEO, 64 * 64)
    with pytest.raises(TooLittleMemoryError, match=r"about 342 MB of memory.*take 60 MB \(the lim"):
        check_memory(PAINT_VIDEO, 1280 * 720)


def test_with_swap_space_a_control_group_forbids_nothing(system):
    system("0::/\n", swap_kb=1000, memory_max="60000000")
    assert group_limit_bytes() is None


def test_a_system_without_proc_has_no_known_limit(monkeypatch, tmp_path):
    monkeypatch.setattr(machine, "_PROC", tmp_path)
    assert group_limit_bytes() is None


def test_without_proc_the_peak_is_that_of_getrusage(monkeypatch, tmp_path):
    monkeypatch.setattr(machine, "_PROC", tmp_path)
    assert peak_memory_bytes() >= 1 << 20
