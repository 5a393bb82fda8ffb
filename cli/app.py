"""The group of commands, and `apply` as the one that needs no name."""

from importlib.metadata import version
from typing import Annotated, Any

import typer
from makeup_video.cli.apply import apply
from makeup_video.cli.bench import bench
from makeup_video.cli.demo import demo
from makeup_video.cli.estimate import estimate
from makeup_video.cli.inspect import inspect
from makeup_video.cli.live import live
from typer.core import TyperGroup

_DEFAULT = "apply"
_EPILOG = (
    "Without a command name, `apply` runs: makeup-video IN --color '#B4002E' -o OUT. "
    "A file that is named like a command is given as ./NAME. "
    "Exit codes: 0 done; 1 the machine lacks something, or a fault of ours; 2 options or look file "
    "wrong, or the output exists; 3 the input or the photo cannot be read; 4 the output cannot be "
    "written; 5 done, but the input was damaged; 6 --strict, and something could not be kept; "
    "130 stopped by Ctrl-C before the output was whole."
)


class DefaultGroup(TyperGroup):
    """Runs `apply` when the first word is neither a command nor an option of the group."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        own = {name for param in self.params for name in (*param.opts, *param.secondary_opts)}
        own |= set(self.get_help_option_names(ctx))
        if args and args[0] not in own and args[0] not in self.commands:
            args = [_DEFAULT, *args]
        return super().parse_args(ctx, args)


app = typer.Typer(
    cls=DefaultGroup,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    epilog=_EPILOG,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(apply)
app.command()(estimate)
app.command()(inspect)
app.command()(live)
app.command()(demo)
app.command()(bench)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"makeup-video {version('makeup-video')}")
        raise typer.Exit


@app.callback()
def group(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    """Paint the makeup of a look on every frame of a video; everything else stays as it was."""
