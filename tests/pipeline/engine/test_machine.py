"""Memory of the process: the peak, and giving freed memory back to the system."""

import os
import subprocess
import sys

import cv2
import numpy as np
import pytest
from makeup_video.pipeline.engine import machine
from makeup_video.pipeline.engine.machine import (
    cpu_seconds_of_children,
    give_back_memory,
    one_opencv_thread,
    peak_memory_bytes,
)

_FREED = """
from pathlib import Path
import numpy as np
from makeup_video.pipeline.engine.machine import give_back_memory

def held():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

small = [np.ones(8_000) for _ in range(1000)]  # 64 MB in pieces that glibc takes from its heap
keep = np.ones(8_000)
del small
before = held()
give_back_memory()
print(before - held())
"""


_LARGE = """
from pathlib import Path
import numpy as np
from makeup_video.pipeline.engine import machine

def held():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

{}
np.ones(30_000_000, np.uint8)  # freed at once: from now on glibc counts 1 MB as small
blocks = []
for _ in range(100):
    blocks += [np.ones(1_000_000, np.uint8), np.ones(50_000, np.uint8)]
before = held()
del blocks[::2]
print(before - held())
"""


def test_large_blocks_go_back_to_the_system_at_once():
    def freed_bytes(call):
        command = [sys.executable, "-c", _LARGE.format(call)]
        return int(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)

    assert freed_bytes("machine.return_large_blocks()") > 95e6
    assert freed_bytes("") < 50e6


_REUSED = """
import resource
import numpy as np
from makeup_video.pipeline.engine.machine import return_large_blocks

return_large_blocks()
np.ones(700_000, np.uint8)
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(100):
    np.ones(700_000, np.uint8)
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def test_blocks_of_the_nets_are_used_again():
    """The lip net allocates and frees 0.7 MB, 170 pages, for each face of each frame."""
    faults = subprocess.check_output([sys.executable, "-c", _REUSED], text=True)
    assert int(faults) < 100


def test_the_peak_counts_what_was_held_and_never_falls():
    before = peak_memory_bytes()
    block = np.ones(60_000_000, np.uint8)
    held = peak_memory_bytes()
    del block
    # the kernel counts pages in batches, so the figure may be slightly too low
    assert held > max(before, 60_000_000) - 1e6
    assert peak_memory_bytes() > held - 1e6


def test_freed_memory_is_given_back_and_the_rest_stays():
    kept = np.arange(100_000)
    give_back_memory()
    assert (kept == np.arange(100_000)).all()
    if sys.platform == "linux":
        freed = subprocess.check_output([sys.executable, "-c", _FREED], text=True)
        assert int(freed) > 30e6


def test_opencv_has_its_threads_back_after_the_last_block():
    cv2.setNumThreads(2)
    first, second = one_opencv_thread(), one_opencv_thread()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert cv2.getNumThreads() == 1
    second.__exit__(None, None, None)
    assert cv2.getNumThreads() == 2


_FORKED = """
import os, sys
import cv2, numpy as np
from makeup_video.pipeline import Look, Painter, product
cv2.setNumThreads(2)
for _ in range(20):
    cv2.GaussianBlur(np.zeros((2000, 2000, 3), np.uint8), (0, 0), 5)
child = os.fork()
if child == 0:
    Painter(Look(lips=product("red", "matte")))(np.zeros((360, 640, 3), np.uint8), 0)
    os._exit(0 if cv2.getNumThreads() == 2 else 5)
assert cv2.getNumThreads() == 2
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_does_not_wait_for_threads_it_lacks():
    command = [sys.executable, "-W", "ignore", "-c", _FORKED]
    assert subprocess.run(command, timeout=60, check=False).returncode == 0


def test_a_system_without_limits_has_none():
    """Windows has no module `resource`."""
    code = (
        "import sys; sys.modules['resource'] = None\n"
        "from makeup_video.pipeline import Look, process_video\n"
        "from makeup_video.pipeline.engine.machine import *\n"
        "check_memory(PAINT_VIDEO, 10**6); assert free_memory_bytes() > 0\n"
        "sys.platform = 'win32'; assert peak_memory_bytes() == 0"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_cpu_time_of_children_counts_once_they_have_ended():
    before = cpu_seconds_of_children()
    code = "import time\nwhile time.process_time() < 0.3: pass"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
    assert cpu_seconds_of_children() - before >= 0.3


def test_what_runs_have_left_is_freed_at_most_once_a_second(monkeypatch):
    clock, searches = [100.0], []
    monkeypatch.setattr(machine.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(machine.gc, "collect", lambda generation=2: searches.append(generation))
    monkeypatch.setattr(machine, "_given_back_at", 0.0)
    for clock[0] in (100.0, 100.5, 100.9, 101.1, 101.2, 109.0):
        machine.give_back_last_run()
    assert searches.count(2) == 3
