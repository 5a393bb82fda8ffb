"""Help pages: every option in one group, examples that parse, no text cut."""

import io
import os
import re
import shlex
from contextlib import redirect_stdout
from unittest.mock import patch

import pytest
from makeup_video.cli.app import app
from makeup_video.cli.options import GROUPS
from typer.main import get_command

COMMANDS = ("apply", "estimate", "inspect", "live", "demo", "bench")
SECTION = re.compile(r"^(\w[\w ]*):\n((?:  .*\n)*)", re.MULTILINE)


def help_of(*words, columns=80):
    """The command's output on a terminal of this width; CliRunner supports only 80 columns."""
    text = io.StringIO()
    with redirect_stdout(text), patch.dict(os.environ, COLUMNS=str(columns)):
        app([*words, "--help"], standalone_mode=False)
    return text.getvalue()


def sections(text):
    return {title: body for title, body in SECTION.findall(text)}


def heads(body):
    """The left column: each entry begins two characters from the edge."""
    return re.findall(r"^  (\S.*?)(?:  .*)?$", body, re.MULTILINE)


def pages():
    group = get_command(app)
    yield (), [*group.commands["apply"].params, *group.params]
    for name in COMMANDS:
        yield (name,), group.commands[name].params


def test_the_main_page_shows_the_headline_options_first():
    found = sections(help_of())
    assert [head.split()[0] for head in heads(found["Look"])][:2] == ["--ref", "--color"]
    assert heads(found["Output"])[0].startswith("-o, --output")
    assert list(found)[1:5] == ["Look", "Faces", "Output", "Run"]


def test_the_main_page_lists_the_other_commands():
    assert [head.split()[0] for head in heads(sections(help_of())["Commands"])] == [*COMMANDS[1:]]


@pytest.mark.parametrize("columns", [60, 80, 200])
@pytest.mark.parametrize("words", [(), *((name,) for name in COMMANDS)])
def test_no_text_is_cut_or_wider_than_the_terminal(words, columns):
    text = help_of(*words, columns=columns)
    assert "…" not in text and "..." not in text
    assert max(map(len, text.splitlines())) <= min(columns, 80)


@pytest.mark.parametrize("words", [(), *((name,) for name in COMMANDS)])
def test_every_option_is_in_one_group_of_the_help(words):
    groups = {name: body for name, body in sections(help_of(*words)).items() if name in GROUPS}
    shown = [head for body in groups.values() for head in heads(body)]
    for param in dict(pages())[words]:
        if param.param_type_name == "option":
            flags = [*param.opts, *param.secondary_opts]
            matching = [head for head in shown if set(flags) <= set(re.split(r"[\s,/]+", head))]
            assert len(matching) == 1, (flags, matching)
            assert param.rich_help_panel in groups and param.help


@pytest.mark.parametrize("words", [(), *((name,) for name in COMMANDS)])
def test_examples_parse_as_the_command_takes_them(words):
    group = get_command(app)
    lines = sections(help_of(*words))["Examples"].splitlines()
    assert 2 <= len(lines) <= 3
    for line in lines:
        program, *typed = shlex.split(line)
        assert program == "makeup-video"
        name = typed.pop(0) if words and words != ("apply",) else "apply"
        assert name == (words or ("apply",))[0]
        command = group.commands[name]
        command.make_context(name, typed, parent=group.context_class(group))


def test_the_main_page_has_three_examples():
    assert len(sections(help_of())["Examples"].splitlines()) == 3


def test_exit_codes_are_a_table_on_the_main_page():
    codes = [head.split()[0] for head in heads(sections(help_of())["Exit codes"])]
    assert codes == ["0", "1", "2", "3", "4", "5", "6", "130"]
