"""How to know that memory ran out, whatever raises the error.

The command imports this module before all that may need much memory, so it needs nothing else.
"""

# How loader, threads, C++ and OpenCL say it.
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
    """True for a MemoryError, and for what loader, threads, C++ and OpenCL raise in its place."""
    text = str(error).lower()
    return isinstance(error, MemoryError) or any(phrase in text for phrase in _PHRASES)
