"""The product sends nothing and fetches nothing: the kernel ends a process that tries."""

import os
import re
import signal
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest
import sandbox

ROOT = Path(__file__).parent.parent
SAMPLES = ROOT / "samples"
TOOL = Path(sandbox.__file__)
COMMAND = [sys.executable, "-m", "makeup_video.cli"]
pytestmark = pytest.mark.skipif(not sandbox.is_there(), reason="no seccomp filters on this system")


def run(tmp_path, *command, mode="quiet"):
    """Run the command with its own home; SIGSYS ends a process that uses the network.

    Telemetry stays off even if the environment switches it on.
    """
    home = {"HOME": str(tmp_path), "XDG_CACHE_HOME": "", "ORT_DISABLE_TELEMETRY": "0"}
    return subprocess.run(
        [sys.executable, str(TOOL), mode, *map(str, command)],
        cwd=tmp_path,
        env={**os.environ, **home},
        capture_output=True,
        text=True,
        check=False,
        timeout=100,
    )


@pytest.mark.parametrize("mode", ["quiet", "serves"])
@pytest.mark.parametrize(
    "attempt",
    [
        "socket.create_connection(('127.0.0.1', 9))",
        "socket.socket(type=socket.SOCK_DGRAM).sendto(b'x', ('127.0.0.1', 9))",
        "socket.socket(socket.AF_INET6).connect(('::1', 9))",
        "socket.getaddrinfo('example.org', 80)",
    ],
)
def test_the_sandbox_kills_a_process_that_tries(tmp_path, mode, attempt):
    done = run(tmp_path, sys.executable, "-c", f"import socket; {attempt}", mode=mode)
    assert done.returncode == -signal.SIGSYS


@pytest.mark.parametrize(
    "words",
    [
        [SAMPLES / "in.mp4", "--ref", SAMPLES / "look.jpg", "-o", "out.mp4", "--end", "0.2"],
        [SAMPLES / "portrait.jpg", "--color", "B4002E", "-o", "out.jpg"],
        ["estimate", SAMPLES / "look.jpg", "-o", "look.json"],
        ["inspect", SAMPLES / "portrait.jpg", "-o", "out.jpg"],
        ["--version"],
    ],
    ids=lambda words: str(words[0]).rsplit("/")[-1],
)
def test_no_command_opens_an_internet_socket(tmp_path, words):
    done = run(tmp_path, *COMMAND, *words)
    assert done.returncode == 0, done.stderr
    assert not list(tmp_path.rglob("Microsoft"))


def test_nets_that_stay_loaded_send_nothing_later(tmp_path):
    """ONNX Runtime would send telemetry after some ten seconds, and store a device id at once."""
    program = (
        "import sys, time, numpy as np\n"
        "from makeup_video.pipeline import find_faces\n"
        "find_faces(np.zeros((64, 64, 3), np.uint8))\n"
        "assert 'onnxruntime' in sys.modules\n"
        "time.sleep(15)"
    )
    done = run(tmp_path, sys.executable, "-c", program)
    assert done.returncode == 0, done.stderr
    assert not list(tmp_path.rglob("Microsoft"))


@pytest.mark.parametrize(
    "words",
    [
        ["live", "--camera", SAMPLES / "in.mp4", "--ref", SAMPLES / "look.jpg"],
        ["demo", "--ref", SAMPLES / "look.jpg"],
    ],
    ids=["live", "demo"],
)
def test_a_served_page_only_listens(tmp_path, words):
    command = [*COMMAND, *words, "--port", "0", "--no-browser"]
    with subprocess.Popen(
        [sys.executable, str(TOOL), "serves", *map(str, command)],
        cwd=tmp_path,
        env={**os.environ, "HOME": str(tmp_path), "XDG_CACHE_HOME": ""},
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        for line in process.stderr:
            if found := re.search(r"http://\S+", line):
                break
        assert urllib.request.urlopen(found[0]).status == 200
        time.sleep(1)  # gives background threads time to try
        process.send_signal(signal.SIGINT)
        process.stderr.read()
    assert process.returncode == 0
    assert not list(tmp_path.rglob("Microsoft"))


@pytest.mark.parametrize(
    "module",
    ["pipeline", "pipeline.faces.net", "training", "web.app", "cli.main", "benchmark.floor"],
)
def test_telemetry_is_off_before_onnx_runtime_is_imported(module):
    program = (
        "import importlib.abc, os, sys\n"
        "class Watch(importlib.abc.MetaPathFinder):\n"
        "    def find_spec(self, name, path, target=None):\n"
        "        if name == 'onnxruntime':\n"
        "            assert os.environ['ORT_DISABLE_TELEMETRY'] == '1'\n"
        "sys.meta_path.insert(0, Watch())\n"
        f"import makeup_video.{module}\n"
        "import makeup_video.pipeline, onnxruntime"
    )
    environment = {**os.environ, "ORT_DISABLE_TELEMETRY": "0"}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_only_one_module_imports_onnx_runtime():
    uses = {
        path.relative_to(ROOT).as_posix()
        for folder in ("pipeline", "kernels", "web", "benchmark", "cli", "docs", "samples")
        for path in (ROOT / folder).rglob("*.py")
        if re.search(r"^(import|from) onnxruntime", path.read_text(), re.MULTILINE)
    }
    assert uses == {"pipeline/faces/net.py"}
