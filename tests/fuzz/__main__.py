"""Feeds damaged files to makeup-video: `python -m tests.fuzz`, from the root of the repository.

Without options it plays the cases of CI: 400 videos, 400 photos and 200 texts, from seed 1. Each
runs in a process of its own, with limits of time and memory. A case is wrong when it crashes,
hangs, raises an error that is not ours or not one line, leaves a file behind, changes its input, or
writes an output that is not what its report says. Every wrong case is printed with the command that
repeats it alone, and the exit code is then 1.
"""

import os
import sys
from pathlib import Path

# Before anything is imported: a fork keeps only the thread that forks, so there must be no other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
tests = Path(__file__).parents[1]
sys.path[:0] = [str(tests), str(tests / "support")]  # where pytest finds its helpers, too

from fuzz.run import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
