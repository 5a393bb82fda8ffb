"""Options that several commands share: defined once, and passed as one value."""

import ast
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Annotated

import pytest
import typer
from makeup_video.cli.app import app
from makeup_video.cli.look_options import LookOptions
from makeup_video.cli.looks_options import LooksOptions
from makeup_video.cli.options import parse_time, with_options
from makeup_video.cli.output_options import OutputOptions
from makeup_video.pipeline import Look, PhotoError, UsageError, product, ready_look
from makeup_video.pipeline.reference import estimate
from reference_photos import certain
from typer.main import get_command
from typer.testing import CliRunner

CLI = Path(__file__).parents[2] / "cli"


@dataclass(frozen=True, slots=True, kw_only=True)
class Size:
    width: int = 4
    height: Annotated[int, typer.Option(metavar="PX")] = 3


def test_a_dataclass_of_options_reaches_the_command_whole():
    got = []

    @with_options
    def draw(size: Size, name: str, fill: bool = False) -> None:
        """Draw."""
        got.append((size, name, fill))

    single = typer.Typer()
    single.command()(draw)
    assert CliRunner().invoke(single, ["a", "--height", "7", "--fill"]).exit_code == 0
    assert got == [(Size(width=4, height=7), "a", True)]
    assert draw.__doc__ == "Draw."


def test_apply_batch_and_live_share_every_change_of_a_look():
    commands = get_command(app).commands
    wholes = set(LooksOptions.__dataclass_fields__) - set(LookOptions.__dataclass_fields__)
    assert wholes == {"looks", "catalogue", "where"}
    for name in LookOptions.__dataclass_fields__:
        if name in ("look", "ref"):
            continue  # apply and batch take these several times
        of_apply, of_batch, of_live = (
            next(param for param in commands[command].params if param.name == name)
            for command in ("apply", "batch", "live")
        )
        for key in ("opts", "secondary_opts", "metavar", "help", "default", "rich_help_panel"):
            assert getattr(of_apply, key) == getattr(of_batch, key) == getattr(of_live, key)


def test_no_two_options_are_defined_with_the_same_text():
    texts = []
    for path in CLI.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.keyword) and node.arg == "help":
                texts.append(ast.unparse(node.value))
    assert len(texts) == len(set(texts))


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        (None, None),
        ("12.5", Fraction(25, 2)),
        (".5", Fraction(1, 2)),
        ("1:02.5", Fraction(125, 2)),
        ("1:00:01", 3601),
        ("12.5s", Fraction(25, 2)),
        ("1m 2.5s", Fraction(125, 2)),
        ("90 sec", 90),
        ("2min", 120),
        ("1H 1s", 3601),
        (" 10", 10),
        (" 10s ", 10),
        ("1:30\t", 90),
    ],
)
def test_times_are_read_exactly(text, seconds):
    assert parse_time(text, "--start") == seconds


@pytest.mark.parametrize(
    "text", ["", "x", "-1", "1:60", "1e3", ".", "1.", "1:2:3:4", "s", "1h1h", "1s 1m", "1.5h"]
)
def test_other_times_are_refused(text):
    with pytest.raises(UsageError, match="--end"):
        parse_time(text, "--end")


def test_a_refused_time_is_shown_as_it_was_given():
    with pytest.raises(UsageError, match="got ' 1X'"):
        parse_time(" 1X", "--end")


def test_a_split_counts_by_its_decimals():
    settings = OutputOptions().settings(LooksOptions(), overwrite=False, split=0.1)
    assert settings.split_minutes == Fraction(1, 10)


def test_the_base_look_is_that_of_a_file_a_photo_or_nothing(tmp_path, monkeypatch, capsys):
    lips = Look(lips=product((180, 0, 46), "gloss"))
    lips.save(tmp_path / "look.json")
    assert LookOptions().base_look(quiet=True) is None
    assert LookOptions(look="none").base_look(quiet=True) == Look()
    assert LookOptions(look="glam").base_look(quiet=True) == ready_look("glam").look
    assert LookOptions(look=str(tmp_path / "look.json")).base_look(quiet=True) == lips
    monkeypatch.setattr(estimate, "estimate_from", lambda *_: certain(lips))
    assert LookOptions(ref="a.jpg").base_look(quiet=True) == lips
    assert capsys.readouterr().err == ""
    assert LookOptions(ref="a.jpg").base_look(quiet=False) == lips
    assert capsys.readouterr().err.startswith("a.jpg: lips #B4002E")


@pytest.mark.parametrize(
    ("options", "files"),
    [({}, []), ({"look": ["none", "glam"]}, []), ({"ref": ["a.jpg"]}, ["a.jpg"]),
     ({"look": ["look.json"], "catalogue": "b.csv"}, ["look.json", "b.csv"])],
)  # fmt: skip
def test_only_files_are_kept_from_being_overwritten(options, files):
    assert LooksOptions(**options).files == files


def test_a_bare_photo_needs_a_colour(monkeypatch):
    monkeypatch.setattr(estimate, "estimate_from", lambda *_: certain(Look()))
    with pytest.raises(PhotoError, match="add --color"):
        LookOptions(ref="a.jpg").base_look(quiet=True)
    assert LookOptions(ref="a.jpg", color="B02").base_look(quiet=True) == Look()
    assert LookOptions(ref="a.jpg", blush="pink").base_look(quiet=True) == Look()


def test_options_of_the_look_become_a_choice():
    choice = LookOptions(color="B02", finish="gloss", strength="0.5", liner="black").choice()
    assert (choice.color, choice.finish, choice.strength) == ("B02", "gloss", "0.5")
    assert choice.base is None and choice.parts is None and choice.worn == {"liner": "black"}
