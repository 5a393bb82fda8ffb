"""Help pages: every option in one group, examples that parse, no text cut."""

import io
import os
import re
import shlex
import subprocess
import sys
from contextlib import redirect_stdout
from unittest.mock import patch

import pytest
from makeup_video.cli.app import app
from makeup_video.cli.options import GROUPS, RUN
from makeup_video.pipeline import FINISHES, UsageError
from makeup_video.pipeline.files.template import FIELDS
from makeup_video.pipeline.look.kinds import KINDS, PARTS
from makeup_video.pipeline.look.options import PARTS_IN_WORDS, parse_parts
from makeup_video.pipeline.look.part_options import layers_of
from typer.main import get_command

COMMANDS = (
    "apply",
    "batch",
    "looks",
    "estimate",
    "inspect",
    "live",
    "demo",
    "devices",
    "doctor",
    "bench",
)
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
    assert [head.split()[0] for head in heads(found["Look"])][:2] == ["--ref", "--look"]
    assert heads(found["Output"])[0].startswith("-o, --output")
    assert list(found)[1:5] == ["Look", "Faces", "Output", "Run"]


def test_the_main_page_lists_the_other_commands():
    assert [head.split()[0] for head in heads(sections(help_of())["Commands"])] == [*COMMANDS[1:]]


@pytest.mark.parametrize("columns", [40, 41, 60, 80, 100, 200])
@pytest.mark.parametrize("words", [(), *((name,) for name in COMMANDS)])
def test_no_text_is_cut_or_wider_than_the_terminal(words, columns):
    text = help_of(*words, columns=columns)
    assert "…" not in text and "..." not in text
    assert max(map(len, text.splitlines())) <= min(columns, 100)


def test_a_wide_terminal_gets_longer_lines():
    widths = [max(map(len, help_of(columns=n).splitlines())) for n in (40, 60, 80, 100)]
    assert widths == sorted(set(widths)) and widths[-1] > 90


def test_a_long_example_is_broken_as_a_shell_continues_it():
    wide, narrow = (sections(help_of(columns=n))["Examples"] for n in (100, 40))
    assert " \\\n" in narrow and " \\\n" not in wide
    assert [shlex.split(line) for line in narrow.replace("\\\n", "").splitlines()] == [
        shlex.split(line) for line in wide.splitlines()
    ]


def test_the_help_of_the_look_lists_what_the_tables_hold():
    look = " ".join(sections(help_of())["Look"].split())
    slots = [*KINDS["eyeshadow"].slots]
    assert f"{', '.join([*FINISHES][:-1])} or {[*FINISHES][-1]}." in look
    assert f"{', '.join(slots[:-1])} or {slots[-1]}." in look
    pages = "".join(help_of(name) for name in COMMANDS)
    assert set(re.findall("{(.*?)}", pages)) == set(FIELDS)  # the fields of templates


def test_help_and_error_of_parts_list_the_same_choices():
    with pytest.raises(UsageError, match=f"parts must be {PARTS_IN_WORDS}, got") as caught:
        parse_parts("nose")
    assert all(name in str(caught.value) for name in PARTS)
    assert f"--parts PARTS {PARTS_IN_WORDS}; default" in " ".join(help_of().split())


def test_every_part_has_an_option_with_an_example_that_works():
    look = sections(help_of(columns=100))["Look"]
    for part, kind in PARTS.items():
        assert f"  --{part} COLOUR[:WORD]" in look
        (example,) = re.findall(rf"{kind.product}, as in '([^']+)'", " ".join(look.split()))
        assert layers_of(part, example)[0].product.hex == "#" + bytes(kind.first_rgb).hex().upper()


def test_no_large_library_is_loaded_for_a_help_page():
    code = (
        "import sys; from makeup_video.cli.app import app\n"
        "assert 'makeup_video.pipeline.media.codecs' not in sys.modules\n"
        "app(['--help'], standalone_mode=False)\n"
        "large = {'numpy', 'PIL', 'av', 'cv2', 'rich'} & set(sys.modules)\n"
        "assert 'makeup_video.pipeline.media.codecs' in sys.modules and not large, large"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)


@pytest.mark.parametrize("words", [(), *((name,) for name in COMMANDS)])
def test_every_option_is_in_one_group_of_the_help(words):
    groups = {name: body for name, body in sections(help_of(*words)).items() if name in GROUPS}
    shown = [head for body in groups.values() for head in heads(body)]
    for param in dict(pages())[words]:
        if param.param_type_name == "option":
            flags = [*param.opts, *param.secondary_opts]
            matching = [head for head in shown if set(flags) <= set(re.split(r"[\s,/]+", head))]
            assert len(matching) == 1, (flags, matching)
            # Typer's own options, for shell completion, name no group
            assert (param.rich_help_panel or RUN) in groups and param.help


@pytest.mark.parametrize("words", [(), *((name,) for name in COMMANDS)])
def test_examples_parse_as_the_command_takes_them(words):
    group = get_command(app)
    lines = sections(help_of(*words))["Examples"].splitlines()
    assert 2 <= len(lines) <= 5
    for line in lines:
        program, *typed = shlex.split(line)
        assert program == "makeup-video"
        name = typed.pop(0) if words and words != ("apply",) else "apply"
        assert name == (words or ("apply",))[0]
        command = group.commands[name]
        command.make_context(name, typed, parent=group.context_class(group))


def test_the_main_page_shows_how_to_replace_a_part():
    examples = sections(help_of(columns=100))["Examples"]
    assert "--ref look.jpg --lips '#C0392B:gloss'" in examples and "--look cat-eye" in examples


def test_exit_codes_are_a_table_on_the_main_page():
    codes = [head.split()[0] for head in heads(sections(help_of())["Exit codes"])]
    assert codes == ["0", "1", "2", "3", "4", "5", "6", "130"]
