"""Mistyped commands and options: one line with a suggestion and the help page to read."""

import subprocess
import sys

import pytest

MODULES = ("makeup_video", "makeup_video.cli")


def run(*words, module="makeup_video.cli"):
    """The exit code and the single output line of the real command."""
    done = subprocess.run(
        [sys.executable, "-m", module, *words], capture_output=True, text=True, check=False
    )
    (line,) = done.stderr.splitlines()
    assert done.stdout == ""
    return done.returncode, line


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("words", "text", "page"),
    [
        (["inspct"], "did you mean inspect?", "makeup-video --help"),
        (["Lvie", "--ref", "a.jpg"], "did you mean live?", "makeup-video --help"),
        (["in.mp4", "--colr", "B02"], "--colr: did you mean --color?", "makeup-video --help"),
        (["estimate", "a.jpg", "--jsn"], "did you mean --json?", "makeup-video estimate --help"),
        (["in.mp4", "--helpp"], "did you mean --help?", "makeup-video --help"),
        (["in.mp4", "--qqqq"], "has no option --qqqq.", "makeup-video --help"),
        (["in.mp4", "--port", "1"], "option of makeup-video live and", "makeup-video live --help"),
        (["live", "--codec", "av1"], "it is an option of makeup-video.", "makeup-video --help"),
        (["live", "--port", "x"], "Invalid value for '--port'", "makeup-video live --help"),
        (["live", "-o"], "Option '-o' requires an argument", "makeup-video live --help"),
        (["inspect", "in.mp4"], "Missing option '-o'", "makeup-video inspect --help"),
        (["in.mp4"], "Missing option '-o'", "makeup-video --help"),
        (["a", "b", "-o", "c"], "unexpected extra argument", "makeup-video --help"),
        (["bench", "--sizes", "x"], "--sizes must be", "makeup-video bench --help"),
        (["in.mp4", "-o", "o.mp4", "--start", "x"], "--start must be", "makeup-video --help"),
    ],
)  # fmt: skip
def test_the_line_says_what_was_meant_and_which_help_lists_it(words, text, page):
    code, line = run(*words)
    assert code == 2 and line.startswith("UsageError: ")
    assert text in line and line.endswith(f" See {page}.")


def test_a_file_named_nearly_like_a_command_is_a_file(folder):
    (folder / "inspct").write_bytes(b"no film")
    code, line = run("inspct", "--look", "none", "-o", "out.mp4")
    assert code == 3 and "did you mean" not in line


@pytest.mark.parametrize("words", [["inspct"], ["in.mp4"], ["live", "--port", "x"]])
def test_both_modules_are_the_same_command(words):
    assert len({run(*words, module=module) for module in MODULES}) == 1


@pytest.mark.parametrize("module", MODULES)
def test_the_help_of_a_module_names_the_command(module):
    text = subprocess.check_output([sys.executable, "-m", module, "live", "--help"], text=True)
    assert text.startswith("Usage: makeup-video live [OPTIONS]")
