"""Feeds damaged files to makeup-video: `python -m tests.fuzz`, from the root of the repository.

Without options it plays the cases of CI: 400 videos, 400 photos and 200 texts, from seed 1. Each
case runs in its own process, with limits on time and memory. A case fails when it crashes, hangs,
raises an error that is not a one-line error of makeup-video, leaves a file behind, changes its
input, or writes an output that contradicts its report. Every failed case is printed with the
command that repeats that case alone, and the exit code is then 1.
"""

import os
import sys
from pathlib import Path

# This must precede all imports: a fork keeps only the forking thread, so there must be no other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
tests = Path(__file__).parents[1]
sys.path[:0] = [str(tests), str(tests / "support")]  # where pytest finds its helpers, too

from fuzz.run import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
