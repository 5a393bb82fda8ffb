"""Options have the values that Typer gives them, and plain options load no pydantic."""

import subprocess
import sys
from typing import Annotated

import pytest
import typer
from makeup_video.cli.help_page import Command
from typer.testing import CliRunner

WORDS = [
    "a",
    "",
    "7",
    "-7",
    "007",
    "1_0",
    " 7",
    "7.0",
    "1e3",
    "0.5",
    "-.5",
    "nan",
    "x",
    "٣",
    "9" * 30,
]


def command(cls):
    """A program that shows its values; cls: our class of commands, or Typer's."""
    app = typer.Typer()

    @app.command(cls=cls)
    def show(
        text: Annotated[str | None, typer.Option()] = None,
        whole: Annotated[int | None, typer.Option()] = 3,
        number: Annotated[float, typer.Option()] = 2,
        least: Annotated[int, typer.Option(min=5)] = 9,
        many: Annotated[list[str] | None, typer.Option()] = None,
        flag: Annotated[bool | None, typer.Option()] = None,
    ) -> None:
        print([text, whole, number, least, many, flag])

    return app


def shown(cls, words):
    done = CliRunner().invoke(command(cls), words)
    return done.exit_code, done.stdout


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("option", ["text", "whole", "number", "least", "many"])
def test_a_word_means_what_it_means_to_typer(option, word):
    words = [f"--{option}={word}"]
    assert shown(Command, words) == shown(None, words)


@pytest.mark.parametrize("words", [[], ["--many", "a", "--many", ""], ["--flag"], ["--no-flag"]])
def test_what_is_not_given_is_what_it_is_to_typer(words):
    assert shown(Command, words) == shown(None, words)


def test_an_ordinary_command_line_loads_no_pydantic():
    code = (
        "import sys; from makeup_video.cli.app import app\n"
        "words = 'no.mp4 --ref no.jpg -q -y --crf 20 --strength 80% --end 1 -o o.mp4'.split()\n"
        "try: app(words, standalone_mode=False)\n"
        "except BaseException as error: assert type(error).__name__ == 'Exit', error\n"
        "assert 'pydantic' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "no.mp4" in done.stderr  # the command itself has run
