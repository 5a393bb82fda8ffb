"""Usage errors in one line: what is wrong, what was meant, which help to read."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

from makeup_video.cli.help_page import DEFAULT, PROGRAM
from makeup_video.cli.outcome import help_page


def usage_line(error: Any) -> str:
    """The line for one of Typer's usage errors.

    A mistyped option comes with the one that was meant; an option of another command with that
    command.
    """
    text = " ".join(error.format_message().split())
    ctx = getattr(error, "ctx", None)
    command = ctx.command.name if ctx and ctx.parent else DEFAULT
    if ctx and type(error).__name__ == "NoSuchOption":
        text, command = _unknown_option(error.option_name, ctx, command)
    return f"{text if text.endswith(('.', '?', '!')) else f'{text}.'} See {help_page(command)}."


def _unknown_option(option: str, ctx: Any, command: str) -> tuple[str, str]:
    """The message about an unknown option, and the command whose help lists what was meant."""
    text = f"{PROGRAM if command == DEFAULT else f'{PROGRAM} {command}'} has no option {option}"
    commands = ctx.find_root().command.commands
    owners = [name for name, other in commands.items() if option in _options(other.params)]
    if owners:
        return f"{text}: it is an option of {_join(owners)}", owners[0]
    meant = get_close_matches(option, _options(ctx.command.get_params(ctx)), 1)
    return (f"{text}: did you mean {meant[0]}?" if meant else text), command


def _options(params: Iterable[Any]) -> list[str]:
    return [name for param in params for name in (*param.opts, *param.secondary_opts)]


def _join(commands: list[str]) -> str:
    """ "live and demo", each as it is typed."""
    names = [PROGRAM if name == DEFAULT else f"{PROGRAM} {name}" for name in commands]
    return " and ".join([", ".join(names[:-1]), names[-1]] if names[1:] else names)
