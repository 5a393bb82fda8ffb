"""The nets of a photo: loaded in a thread while the photo is decoded, and given back."""

import os
import subprocess
import sys
import threading

import pytest
from makeup_video.pipeline import InstallError, look_from_photo
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.reference import nets
from people import SAMPLES


def test_each_net_is_loaded_once_while_the_photo_is_decoded(monkeypatch):
    nets.forget_nets()  # that earlier tests left
    loaded = []

    class Noted(Net):
        def __init__(self, name, **options):
            loaded.append(name)
            super().__init__(name, **options)

    monkeypatch.setattr(nets, "Net", Noted)
    read = look_from_photo(SAMPLES / "look.jpg")
    assert len(read.layers) > 1
    assert sorted(loaded) == [
        f"reference_{name}" for name in ("liner", "lips", "lipstick", "makeup")
    ]
    assert not any(thread.name == "makeup-reference" for thread in threading.enumerate())


def test_nets_that_are_missing_end_with_the_usual_line(monkeypatch):
    def missing(*args, **options):
        raise InstallError("the weights are missing")

    monkeypatch.setattr(nets, "Net", missing)
    with pytest.raises(InstallError, match="the weights are missing"):
        look_from_photo(SAMPLES / "look.jpg")


_FORKED = """
import os, sys
from makeup_video.pipeline import look_from_photo
look_from_photo(sys.argv[1])
child = os.fork()
if child == 0:
    look_from_photo(sys.argv[1])
    os._exit(0)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_photo_is_read_in_a_forked_process_as_well():
    """Threads of a net stay in the process that loaded it, and its end would wait for them."""
    command = [sys.executable, "-W", "ignore", "-c", _FORKED, str(SAMPLES / "look.jpg")]
    assert subprocess.run(command, timeout=60, check=False).returncode == 0


def test_an_error_of_the_thread_comes_where_the_net_is_used(monkeypatch, capfd):
    def full(*args, **options):
        raise MemoryError("bad allocation")

    monkeypatch.setattr(nets, "Net", full)
    nets.forget_nets()
    with nets.loading(["liner"]):
        pass
    assert capfd.readouterr().err == ""
    with pytest.raises(MemoryError, match="bad allocation"):
        nets.reference_net("liner")
