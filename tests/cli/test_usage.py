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
        (["demo", "--portrait", "a.jpg"], "no option --portrait.", "makeup-video demo --help"),
        (["in.mp4", "--helpp"], "did you mean --help?", "makeup-video --help"),
        (["in.mp4", "--foo"], "has no option --foo.", "makeup-video --help"),
        (["in.mp4", "--qqqq"], "has no option --qqqq.", "makeup-video --help"),
        (
            ["in.mp4", "--port", "1"],
            "--port: it is an option of makeup-video live and makeup-video demo.",
            "makeup-video live --help and makeup-video demo --help",
        ),
        (
            ["in.mp4", "--json"],
            "has no option --json: other commands have it.",
            "makeup-video --help",
        ),
        (
            ["live", "--codec", "av1"],
            "it is an option of makeup-video and makeup-video batch.",
            "makeup-video --help and makeup-video batch --help",
        ),
        (["in.mp4", "--vrsion"], "did you mean --version?", "makeup-video --help"),
        (["estimate", "a.jpg", "--top", "5"], "no option --top.", "makeup-video estimate --help"),
        (["live", "--port", "x"], "--port must be a whole number, got 'x'.", "makeup-video live --help"),
        (["i", "-o", "o", "--strength", "x"], "--strength must be a number", "makeup-video --help"),
        (["live", "-o"], "UsageError: -o needs a value.", "makeup-video live --help"),
        (["i", "-o", "o", "--color"], "--color has no colour: quote one that begins with #, as in --color '#B4002E'.", "makeup-video --help"),
        (["i", "--lips", "-o", "o"], "--lips has no colour: quote one", "makeup-video --help"),
        (["live", "--eyes", "--lips", "red"], "--eyes has no colour: quote one", "makeup-video live --help"),
        (["i", "-o", "o", "--color="], "--color has no colour: quote one", "makeup-video --help"),
        (["i", "-o", "o", "--blush", ""], "--blush has no colour: quote one", "makeup-video --help"),
        (["i", "-o", "o", "--lip", "red"], "--lip: did you mean --lips?", "makeup-video --help"),
        (["i", "-o", "o", "--lips", "redd"], "got 'redd': did you mean red?", "makeup-video --help"),
        (["i", "-o", "o", "--lips", "red", "--strength", "70"], "got '70': did you mean 70%?", "makeup-video --help"),
        (["look"], "did you mean looks?", "makeup-video --help"),
        (["looks", "-o", "o"], "-o writes one look: add its NAME", "makeup-video looks --help"),
        (["live", "--quiet=3"], "--quiet takes no value.", "makeup-video live --help"),
        (["inspect", "in.mp4"], "-o/--output is missing.", "makeup-video inspect --help"),
        (["estimate"], "PHOTO is missing.", "makeup-video estimate --help"),
        (["in.mp4", "--crf", "9"], "-o/--output is missing.", "makeup-video --help"),
        (["a", "b", "-o", "c"], "too many arguments: b; makeup-video batch takes several inputs.", "makeup-video --help"),
        (["a", "b.jpg", "c.jpg", "-o", "d"], "too many arguments: b.jpg c.jpg; makeup-video batch takes", "makeup-video --help"),
        (["a", "--looks", "b.json", "c.json", "-o", "d"], "c.json; quote a pattern, as in --looks 'looks/*.json'.", "makeup-video --help"),
        (["estimate", "a.jpg", "b.jpg"], "too many arguments: b.jpg.", "makeup-video estimate --help"),
        (["live", "--look", "a", "--look=b"], "--look is given 2 times, and this command takes one look.", "makeup-video live --help"),
        (["a", "--look", "b", "--faces", "0", "--look", "c", "--faces=1", "-o", "d"], "--faces is given 2 times, and this command takes one choice of faces.", "makeup-video --help"),
        (["demo", "--ref", "a.jpg", "--ref", "b.jpg"], "--ref is given 2 times", "makeup-video demo --help"),
        (["a", "b.jpg", "-o", "c"], "too many arguments: b.jpg; the photo of a look is --ref b.jpg.", "makeup-video --help"),
        (["in.mp4", "-o", "o.mp4", "--end", "0:90"], "--end: what follows a colon must be below 60, as in 1:30, got '0:90'", "makeup-video --help"),
        (["help"], "there is no command and no file help.", "makeup-video --help"),
        (["help", "live"], "there is no command and no file help.", "makeup-video --help"),
        (["foo"], "there is no command and no file foo.", "makeup-video --help"),
        (["live", "--size", "3"], "--size must be WIDTHxHEIGHT", "makeup-video live --help"),
        (["live", "--fps", "0"], "--fps must be in 1..240", "makeup-video live --help"),
        (["live", "--pixels", "x"], "--pixels must be mjpeg or", "makeup-video live --help"),
        (["bench", "--sizes", "x"], "--sizes must be", "makeup-video bench --help"),
        (["in.mp4", "-o", "o.mp4", "--start", "x"], "--start must be", "makeup-video --help"),
    ],
)  # fmt: skip
def test_the_line_says_what_was_meant_and_which_help_lists_it(words, text, page):
    code, line = run(*words)
    assert code == 2 and line.startswith("UsageError: ")
    assert text in line and line.endswith(f" See {page}.")


def test_a_lone_file_lacks_only_its_output(folder):
    (folder / "help").write_bytes(b"no video")
    assert run("help") == (2, "UsageError: -o/--output is missing. See makeup-video --help.")


def test_a_word_before_a_file_is_no_input(folder):
    (folder / "in.mp4").write_bytes(b"no video")
    line = "UsageError: there is no command and no file paint. See makeup-video --help."
    assert run("paint", "in.mp4", "--look", "none", "-o", "out.mp4") == (2, line)


def test_a_file_named_nearly_like_a_command_is_a_file(folder):
    (folder / "inspct").write_bytes(b"no video")
    code, line = run("inspct", "--look", "none", "-o", "out.mp4")
    assert code == 3 and "did you mean" not in line


@pytest.mark.parametrize(
    ("name", "shown"), [("-dash.mp4", "./-dash.mp4"), ("-y a.mp4", "'./-y a.mp4'")]
)
def test_a_file_named_like_an_option_is_shown_as_a_path(folder, name, shown):
    (folder / name).write_bytes(b"no video")
    code, line = run(name, "--look", "none", "-o", "out.mp4")
    assert code == 2 and f": to name the file, write {shown}." in line
    code, line = run(f"./{name}", "--look", "none", "-o", "out.mp4")
    assert code == 3


def test_a_folder_named_like_an_option_is_no_file(folder):
    (folder / "-dash").mkdir()
    code, line = run("-dash", "--look", "none", "-o", "out.mp4")
    assert code == 2 and "to name the file" not in line


def test_what_follows_two_hyphens_is_no_second_look():
    code, line = run("live", "--look", "none", "--", "--look", "b")
    assert code == 2 and "is given 2 times" not in line


@pytest.mark.parametrize("words", [["inspct"], ["in.mp4"], ["live", "--port", "x"]])
def test_both_modules_are_the_same_command(words):
    assert len({run(*words, module=module) for module in MODULES}) == 1


@pytest.mark.parametrize("module", MODULES)
def test_the_help_of_a_module_names_the_command(module):
    text = subprocess.check_output([sys.executable, "-m", module, "live", "--help"], text=True)
    assert text.startswith("Usage: makeup-video live [OPTIONS]")
