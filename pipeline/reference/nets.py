"""The nets that read a photo: loaded at first use, or in a thread beforehand, and given back."""

import threading
from collections.abc import Generator, Iterable
from contextlib import contextmanager, suppress
from functools import cache

from makeup_video.pipeline.faces.net import Net

# The nets of the whole face, of the eyes' corners, of the mouth, and of the crop of the lips, whose
# name is that of its crop. The net of the crop of the eyes is a part of the baseline alone
# (training/reference/read_look.py).
MAKEUP, LINER, LIPSTICK, LIPS = "makeup", "liner", "lipstick", "lips"
_LOADING = threading.Lock()  # no net is loaded twice


def reference_net(name: str) -> Net:
    """A net, loaded at the first call. Any thread may call this. Raises InstallError."""
    with _LOADING:
        return _loaded(name)


@cache
def _loaded(name: str) -> Net:
    # one thread: a second saves nothing, and a process that is forked would wait for it for ever
    return Net(f"reference_{name}", threads=1)


@contextmanager
def loading(names: Iterable[str]) -> Generator[None, None, None]:
    """Load nets in a thread within the block: to decode a photo and find its face takes as long."""
    thread = threading.Thread(target=_load, args=(names,), name="makeup-reference", daemon=True)
    thread.start()
    try:
        yield
    finally:
        thread.join()


def _load(names: Iterable[str]) -> None:
    with suppress(Exception):  # whoever needs the net raises it again
        for name in names:
            reference_net(name)


def forget_nets() -> None:
    """Give the memory of all nets back; loading them again takes 0.1 s."""
    _loaded.cache_clear()
