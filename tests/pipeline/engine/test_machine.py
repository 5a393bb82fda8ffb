"""Memory of the process: the peak, and giving freed memory back to the system."""

import subprocess
import sys

import numpy as np
from makeup_video.pipeline.engine.machine import give_back_memory, peak_memory_bytes

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


def test_the_peak_counts_what_was_held_and_never_falls():
    before = peak_memory_bytes()
    block = np.ones(60_000_000, np.uint8)
    held = peak_memory_bytes()
    del block
    # the kernel counts in batches: a little may be missing at any time
    assert held > max(before, 60_000_000) - 1e6
    assert peak_memory_bytes() > held - 1e6


def test_freed_memory_is_given_back_and_the_rest_stays():
    kept = np.arange(100_000)
    give_back_memory()
    assert (kept == np.arange(100_000)).all()
    if sys.platform == "linux":
        freed = subprocess.check_output([sys.executable, "-c", _FREED], text=True)
        assert int(freed) > 30e6
