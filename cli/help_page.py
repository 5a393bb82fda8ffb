"""Help pages as plain text: options in groups, then commands and examples; wrapped, never cut."""

from collections.abc import Iterable
from typing import Any

from makeup_video.cli.options import GROUPS, RUN
from typer.core import TyperCommand, TyperGroup

PROGRAM, DEFAULT = "makeup-video", "apply"
_EXIT_CODES = (
    ("0", "done"),
    ("1", "the machine lacks something, or a fault of ours"),
    ("2", "options or look file wrong, or the output exists"),
    ("3", "the input or the photo cannot be read"),
    ("4", "the output cannot be written"),
    ("5", "done, but the input was damaged"),
    ("6", "--strict, and something could not be kept"),
    ("130", "stopped by Ctrl-C before the output was whole"),
)


class Command(TyperCommand):
    """A command whose epilog holds its examples, one a line."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse as Typer does; every usage error then knows its command."""
        try:
            return super().parse_args(ctx, args)
        except Exception as error:
            if getattr(error, "ctx", ctx) is None:
                error.ctx = ctx  # type: ignore[attr-defined]
            raise

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write usage, description, options by group, examples."""
        words = f"[{DEFAULT}]" if self.name == DEFAULT else f"{self.name}"
        formatter.write_usage(PROGRAM, f"{words} {_usage(self.get_params(ctx))}")
        self.format_help_text(ctx, formatter)
        _write_options(ctx, formatter, self.get_params(ctx))
        _write_examples(formatter, self)


class Group(TyperGroup):
    """The commands, of which the default one needs no name; the help shows its options, too."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write usage, options of the default command, other commands, examples, exit codes."""
        default = self.commands[DEFAULT]
        params = default.params
        formatter.write_usage(PROGRAM, _usage(params))
        formatter.write_usage(PROGRAM, "COMMAND [OPTIONS]", prefix="       ")
        self.format_help_text(ctx, formatter)
        _write_options(ctx, formatter, [*params, *self.get_params(ctx)])
        others = [command for command in self.commands.values() if command is not default]
        with formatter.section("Commands"):
            formatter.write_dl([(c.name, " ".join((c.help or "").split())) for c in others])
        _write_examples(formatter, default)
        with formatter.section("Exit codes"):
            formatter.write_dl(_EXIT_CODES)
        formatter.write_paragraph()
        formatter.write_text(
            f"`{PROGRAM} COMMAND --help` lists the options of a command. A file that is named like "
            "a command is given as ./NAME."
        )


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
    """Write arguments, then each group of options; an option without a group is one of the run."""
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
                formatter.write_dl(records)


def _filled(text: str) -> str:
    """A help text with the names of a table, such as {codecs}; only the help page
    loads the tables."""
    if "{codecs}" in text:
        from makeup_video.pipeline.media.codecs import codecs_with

        return text.replace("{codecs}", codecs_with(lambda codec: True))
    if "{regions}" in text:
        from makeup_video.pipeline.look.regions import REGIONS

        names = list(REGIONS)
        return text.replace("{regions}", f"{', '.join(names)}, or {','.join(names[:2])}")
    return text


def _write_examples(formatter: Any, command: Any) -> None:
    with formatter.section("Examples"):
        for line in command.epilog.splitlines():
            formatter.write(f"{'':{formatter.current_indent}}{line}\n")
