"""Arrays as arguments of kernels that tests run."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from makeup_video.kernels.program import Device


@contextmanager
def on_device(device: Device, *arrays: np.ndarray) -> Iterator[list[Any]]:
    """Copy arrays to a device, for kernels; when the block ends, the arrays hold the result."""
    memories = [device.memory(array.shape, array.dtype) for array in arrays]
    for memory, array in zip(memories, arrays, strict=True):
        memory.array[:] = array
        memory.send()
    yield [memory.buffer for memory in memories]
    for memory in memories:
        memory.fetch()
    device.finish()
    for memory, array in zip(memories, arrays, strict=True):
        array[:] = memory.array
