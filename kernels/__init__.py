"""OpenCL kernels, and the numpy twins of those that paint.

They make surfaces, products, shares of coats and lines, and paint them on the planes of a frame.
"""

import os

# Set before PyOpenCL is imported. Otherwise PyOpenCL would keep the few lines of Python that it
# makes for each kernel in an SQLite file, which saves no time and fails when the file is damaged or
# the disk is full.
os.environ.setdefault("PYOPENCL_NO_CACHE", "1")
