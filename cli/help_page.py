"""Help pages as plain text: options in groups, then commands and examples; wrapped, never cut."""

import re
import shutil
from collections.abc import Callable, Iterable
from typing import Any

from makeup_video.cli.console import print_result
from makeup_video.cli.options import DEFAULT, GROUPS, PROGRAM, RUN
from makeup_video.cli.outcome import join_words
from makeup_video.cli.plain_values import take_plain_values
from makeup_video.cli.usage import check_colours, check_given_once
from typer.core import TyperCommand, TyperGroup

_NARROWEST, _WIDEST = 40, 100  # columns of a page; a narrower terminal breaks the lines
_TEXT_COLUMNS = 22  # at least, for texts beside options: as long as "[hh:]mm:ss[.fraction]."
_NAMES_COLUMNS = 30  # at most, for the names of options; a longer name gets a line of its own
_BREAK = " \\"  # ends a line that continues on the next one, in a shell
_EXIT_CODES = (
    ("0", "done"),
    ("1", "the machine lacks something, or an internal error"),
    ("2", "options or look file wrong, or the output exists"),
    ("3", "the input or the photo cannot be read"),
    ("4", "the output cannot be written"),
    ("5", "done, but the input was damaged, or some of several outputs failed"),
    ("6", "--strict, and something could not be kept"),
    ("130", "stopped by Ctrl-C before the output was complete"),
)


class Command(TyperCommand):
    """A command whose epilog holds its examples, one a line."""

    def get_help_option(self, ctx: Any) -> Any:
        """The option --help, which reports an error when stdout cannot be written."""
        return _reporting(super().get_help_option(ctx))

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Check and parse the arguments; every usage error then knows its command."""
        check_colours(ctx, self.get_params(ctx), args)
        check_given_once(ctx, self.get_params(ctx), args)
        take_plain_values(self.get_params(ctx))
        try:
            return super().parse_args(ctx, args)
        except Exception as error:
            if getattr(error, "ctx", ctx) is None:
                error.ctx = ctx  # type: ignore[attr-defined]
            raise

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write usage, description, options by group, examples."""
        formatter.width = _columns()
        words = f"[{DEFAULT}]" if self.name == DEFAULT else f"{self.name}"
        formatter.write_usage(PROGRAM, f"{words} {_usage(self.get_params(ctx))}")
        self.format_help_text(ctx, formatter)
        _write_options(ctx, formatter, self.get_params(ctx))
        _write_examples(formatter, self)


class Group(TyperGroup):
    """The commands. The default command needs no name, so the help lists its options, too."""

    def get_help_option(self, ctx: Any) -> Any:
        """The option --help, which reports an error when stdout cannot be written."""
        return _reporting(super().get_help_option(ctx))

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse as Typer does, with pydantic only where it is needed."""
        take_plain_values(self.get_params(ctx))
        return super().parse_args(ctx, args)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write usage, options of the default command, other commands, examples, exit codes."""
        formatter.width = _columns()
        default = self.commands[DEFAULT]
        params = default.params
        formatter.write_usage(PROGRAM, _usage(params))
        formatter.write_usage(PROGRAM, "COMMAND [OPTIONS]", prefix="       ")
        self.format_help_text(ctx, formatter)
        _write_options(ctx, formatter, [*params, *self.get_params(ctx)])
        others = [command for command in self.commands.values() if command is not default]
        with formatter.section("Commands"):
            _write_list(formatter, [(c.name, " ".join((c.help or "").split())) for c in others])
        _write_examples(formatter, default)
        with formatter.section("Exit codes"):
            _write_list(formatter, _EXIT_CODES)
        formatter.write_paragraph()
        formatter.write_text(
            f"`{PROGRAM} COMMAND --help` lists the options of a command. A file that is named like "
            "a command is given as ./NAME."
        )


def _reporting(option: Any) -> Any:
    """The option --help, with a callback that prints the page like any other result."""
    option.callback = _print_page
    return option


def _print_page(ctx: Any, _option: Any, wanted: bool) -> None:
    """Print the help page and exit. Raises OutputError."""
    if wanted and not ctx.resilient_parsing:  # true while a shell completes a line
        print_result(f"{ctx.get_help()}\n")
        ctx.exit()


def _columns() -> int:
    """The width of a page: the width of the terminal, within limits."""
    return min(max(shutil.get_terminal_size().columns, _NARROWEST), _WIDEST)


def _write_list(formatter: Any, rows: Iterable[tuple[Any, str]]) -> None:
    """Write names on the left and texts on the right, within the page."""
    gaps = formatter.current_indent + 2
    most = min(_NAMES_COLUMNS, formatter.width - gaps - _TEXT_COLUMNS)
    formatter.write_dl([*rows], col_max=most)


def _usage(params: Iterable[Any]) -> str:
    """Arguments, required options, and [OPTIONS]."""
    words = []
    for param in params:
        if param.param_type_name == "argument":
            words.append(param.metavar)
        elif param.required:
            words.append(f"{param.opts[0]} {param.metavar}")
    return " ".join([*words, "[OPTIONS]"])


def _write_options(ctx: Any, formatter: Any, params: Iterable[Any]) -> None:
    """Write arguments, then each group of options; an option without a group belongs to "Run"."""
    groups: dict[str, list[Any]] = {name: [] for name in ("Arguments", *GROUPS)}
    for param in params:
        if param.param_type_name == "argument":
            groups["Arguments"].append((param.metavar, param.help))
        else:
            group = getattr(param, "rich_help_panel", None) or RUN
            name, text = param.get_help_record(ctx)
            groups[group].append((name, _filled(text)))
    for name, records in groups.items():
        if records:
            with formatter.section(name):
                _write_list(formatter, records)


def _codecs() -> str:
    from makeup_video.pipeline.media.codecs import codecs_with

    return codecs_with(lambda codec: True)


def _hardware() -> str:
    from makeup_video.pipeline.media.hardware import HARDWARE

    return ", ".join(HARDWARE)


def _parts() -> str:
    from makeup_video.pipeline.look.options import PARTS_IN_WORDS

    return PARTS_IN_WORDS


def _default_parts() -> str:
    from makeup_video.pipeline.look.options import DEFAULT_PARTS

    return ", ".join(DEFAULT_PARTS)


def _finishes() -> str:
    from makeup_video.pipeline.look.finishes import FINISHES

    return join_words(FINISHES, "or")


def _zones() -> str:
    from makeup_video.pipeline.look.kinds import KINDS

    return join_words(KINDS["eyeshadow"].slots, "or")


# What a word in braces stands for in a help text. Only a help page loads the tables.
_TABLES: dict[str, Callable[[], str]] = {
    "codecs": _codecs,
    "hardware": _hardware,
    "parts": _parts,
    "default_parts": _default_parts,
    "finishes": _finishes,
    "zone": _zones,
}


def _filled(text: str) -> str:
    """Fill in the words in braces that name a table; other words in braces, as {look}, stay."""
    return re.sub(f"{{({'|'.join(_TABLES)})}}", lambda found: _TABLES[found[1]](), text)


def _write_examples(formatter: Any, command: Any) -> None:
    with formatter.section("Examples"):
        for line in command.epilog.splitlines():
            _write_command_line(formatter, line)


def _write_command_line(formatter: Any, line: str) -> None:
    """Write a command line that can be pasted; a long one is broken by backslashes."""
    indent = " " * formatter.current_indent
    written = ""
    for word in line.split(" "):
        longer = f"{written} {word}" if written else indent + word
        if len(longer) + len(_BREAK) > formatter.width and len(f"{indent}{line}") > formatter.width:
            formatter.write(f"{written}{_BREAK}\n")
            longer = f"{indent}  {word}"
        written = longer
    formatter.write(f"{written}\n")
