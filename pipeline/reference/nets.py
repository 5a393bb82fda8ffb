"""The nets that read a photo: loaded at first use, or beforehand in a thread, and freed."""

import threading
from collections.abc import Generator, Iterable
from contextlib import contextmanager, suppress
from functools import cache

from makeup_video.pipeline.faces.net import Net

# The nets of the whole face, of the eyes' corners, of the mouth, and of the crop of the lips. The
# last has the name of its crop. Only the baseline uses the net of the crop of the eyes
# (training/reference/read_look.py).
MAKEUP, LINER, LIPSTICK, LIPS = "makeup", "liner", "lipstick", "lips"
_LOADING = threading.Lock()  # so that no two threads load the same net


def reference_net(name: str) -> Net:
    """A net, loaded at the first call. Any thread may call this. Raises InstallError."""
    with _LOADING:
        return _loaded(name)


@cache
def _loaded(name: str) -> Net:
    # one thread: a second one saves no time, and a forked process would wait for it for ever
    return Net(f"reference_{name}", threads=1)


@contextmanager
def loading(names: Iterable[str]) -> Generator[None, None, None]:
    """Load nets in a thread during the block: decoding and finding the face take as long."""
    thread = threading.Thread(target=_load, args=(names,), name="makeup-reference", daemon=True)
    thread.start()
    try:
        yield
    finally:
        thread.join()


def _load(names: Iterable[str]) -> None:
    with suppress(Exception):  # the code that needs the net will raise the error again
        for name in names:
            reference_net(name)


def forget_nets() -> None:
    """Free the memory of all nets; loading them again takes 0.1 s."""
    _loaded.cache_clear()
