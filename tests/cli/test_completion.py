"""Shell completion, which Typer's own code writes: a failure is one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(
    not Path("/dev/full").exists(), reason="writes to a device that is always full"
)


def in_bash(words, home, **variables):
    """Run the command in bash, since Typer detects the shell: (exit code, stdout, stderr)."""
    script = f"{sys.executable} -m makeup_video.cli {words}; exit $?"
    process = subprocess.run(
        ["bash", "-c", script], check=False, capture_output=True, text=True, timeout=60,
        env={**os.environ, "HOME": str(home), **variables},
    )  # fmt: skip
    return process.returncode, process.stdout, process.stderr


def test_the_completion_is_installed(tmp_path):
    code, stdout, stderr = in_bash("--install-completion", tmp_path)
    assert (code, stderr) == (0, "") and "bash completion installed" in stdout
    assert "makeup-video.sh" in (tmp_path / ".bashrc").read_text()


@pytest.mark.parametrize(
    ("words", "what"),
    [
        ("--show-completion", "stdout"),
        ("--install-completion", "stdout or the shell's startup file"),
    ],
)
def test_a_full_stdout_is_one_line(tmp_path, words, what):
    code, _, stderr = in_bash(f"{words} >/dev/full", tmp_path)
    assert code == 4
    assert stderr == f"OutputError: {what} cannot be written: No space left on device\n"


def test_a_shell_whose_pipe_is_full_gets_one_line(tmp_path):
    words = {"COMP_WORDS": "makeup-video li", "COMP_CWORD": "1"}
    code, _, stderr = in_bash(
        ">/dev/full", tmp_path, _MAKEUP_VIDEO_COMPLETE="complete_bash", **words
    )
    assert code == 4 and stderr.startswith("OutputError: stdout cannot be written: ")


def test_a_home_that_takes_no_files_is_one_line(tmp_path):
    home = tmp_path / "home"
    home.write_text("")  # a file: even root cannot write in it
    code, stdout, stderr = in_bash("--install-completion", home)
    assert (code, stdout, len(stderr.splitlines())) == (4, "", 1)
    assert stderr.startswith(f"OutputError: {home}")
    assert stderr.endswith("; --show-completion prints the lines instead\n")


def test_a_startup_file_that_is_not_utf8_stays(tmp_path):
    (tmp_path / ".bashrc").write_bytes(b"\xff\xfe")
    code, _, stderr = in_bash("--install-completion", tmp_path)
    assert (code, len(stderr.splitlines())) == (4, 1)
    assert stderr.startswith("OutputError: the completion cannot be installed: ")
    assert (tmp_path / ".bashrc").read_bytes() == b"\xff\xfe"
