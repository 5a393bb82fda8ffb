"""The commands of `makeup-video`; `apply` is the default command and needs no name."""

import os
from typing import Annotated, Any

import typer
from makeup_video.cli import (
    apply,
    batch,
    bench,
    demo,
    devices,
    doctor,
    estimate,
    inspect,
    live,
    looks,
)
from makeup_video.cli.console import print_result
from makeup_video.cli.help_page import Command, Group
from makeup_video.cli.options import DEFAULT, PROGRAM, RUN
from makeup_video.pipeline.errors import closest

_HELP = "help"  # other programs have a command of this name; here it is --help


class DefaultGroup(Group):
    """Runs the default command if the first word is no command and no option of this group."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        own = {name for param in self.params for name in (*param.opts, *param.secondary_opts)}
        own |= set(self.get_help_option_names(ctx))
        if args and args[0] not in own and args[0] not in self.commands:
            if not ctx.resilient_parsing:  # true while a shell completes a line
                self._check_first_word(ctx, args)
            args = [DEFAULT, *args]
        return super().parse_args(ctx, args)

    def shell_complete(self, ctx: Any, incomplete: str) -> list[Any]:
        """Complete commands, options of this group, and options of the default command."""
        default = self.commands[DEFAULT]
        inner = default.make_context(DEFAULT, [], parent=ctx, resilient_parsing=True)
        return [
            *super().shell_complete(ctx, incomplete),
            *default.shell_complete(inner, incomplete),
        ]

    def _check_first_word(self, ctx: Any, args: list[str]) -> None:
        """Raise a usage error for a first word that cannot be the input of the default command.

        Such a word is no file, folder or option, and is "help" or a mistyped command, stands alone
        or comes before a file. A missing input that options follow is left to the default command,
        which reports it.
        """
        word = args[0]
        if word.startswith("-") or os.path.exists(word):
            return
        if meant := closest(word.lower(), self.commands):
            ctx.fail(f"there is no command and no file {word}: did you mean {meant}?")
        if word == _HELP or len(args) == 1 or os.path.isfile(args[1]):
            ctx.fail(f"there is no command and no file {word}")


app = typer.Typer(
    name=PROGRAM,
    cls=DefaultGroup,
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
_MODULES = (apply, batch, looks, estimate, inspect, live, demo, devices, doctor, bench)
for module in _MODULES:
    name = module.__name__.rpartition(".")[2]
    app.command(name, cls=Command, epilog="\n".join(module.EXAMPLES))(getattr(module, name))


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version  # 10 ms that other runs need not wait for

        print_result(f"makeup-video {version('makeup-video')}\n")
        raise typer.Exit


@app.callback()
def group(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version",
            help="Print the version.",
            callback=_print_version,
            is_eager=True,
            rich_help_panel=RUN,
        ),
    ] = False,
) -> None:
    """Paint the makeup of a look on every frame of a video. Everything else stays as it was as far
    as the output's format can hold it: audio, timing, rotation, colour tags, subtitles, chapters.
    What the format cannot hold is reported in a line."""
