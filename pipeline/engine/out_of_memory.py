"""Tells whether memory ran out, whatever raised the error.

The command imports this module before everything that may need much memory, so the module itself
imports nothing.
"""

# The words with which the loader, threads, C++ and OpenCL say that memory ran out.
_PHRASES = (
    "std::bad_alloc",
    "failed to map segment",
    "can't start new thread",
    "cannot allocate memory",
    "failed to allocate",
    "insufficient memory",
    "out_of_host_memory",
    "mem_object_allocation_failure",
)


def is_out_of_memory(error: Exception) -> bool:
    """True for a MemoryError, and for what the loader, threads, C++ and OpenCL raise instead."""
    text = str(error).lower()
    return isinstance(error, MemoryError) or any(phrase in text for phrase in _PHRASES)
