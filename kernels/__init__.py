"""OpenCL kernels that composite on the planes of a frame."""

import os

# Before PyOpenCL is imported: it would keep the few lines of Python that it makes for each kernel in an SQLite
# file, which saves no time, and fail where that file is damaged or the disk is full.
os.environ.setdefault("PYOPENCL_NO_CACHE", "1")
