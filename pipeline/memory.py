"""How much memory this process holds, and giving back what it no longer needs."""

import ctypes
import gc
import resource
import sys
from pathlib import Path


def peak_memory_bytes() -> int:
    """The most memory that this process ever held (its resident set)."""
    if sys.platform == "linux":
        # getrusage would count the parent's memory from before exec
        for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024  # others count in kB


def give_back_memory() -> None:
    """Hand to the system what was freed: glibc would keep it, and a film would come on top."""
    gc.collect()
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # musl has none, and keeps less
        if trim is not None:
            trim(0)
