"""Usage errors in one line: what is wrong, what the user meant, which help to read."""

import os
import re
import shlex
import sys
from collections.abc import Iterable, Sequence
from typing import Any

from makeup_video.cli.options import COLOUR, DEFAULT
from makeup_video.cli.outcome import as_typed, join_words, with_help_pages
from makeup_video.pipeline.errors import closest

_FEW = 3  # commands that a message names at most
_GIVEN_ONCE = {"--look": "one look", "--ref": "one look", "--faces": "one choice of faces"}
# by the first word of the type of a pydantic error
_KINDS = {"int": "a whole number", "float": "a number"}


def check_colours(ctx: Any, params: Iterable[Any], args: Sequence[str]) -> None:
    """Raise a usage error when no value follows a colour option, at the end or before an option.

    The shell takes an unquoted # for the start of a comment, and drops the colour.
    """
    colours = {name for param in params if _takes_colour(param) for name in param.opts}
    for at, word in enumerate(args):
        if word == "--":
            return
        if word in colours and (at + 1 == len(args) or args[at + 1].startswith("-")):
            ctx.fail(f"{word} has no colour: quote one that begins with #, as in {word} '#B4002E'")


def check_given_once(ctx: Any, params: Iterable[Any], args: Sequence[str]) -> None:
    """Raise a usage error when --look, --ref or --faces is repeated for a command that takes one.

    Otherwise only the last value would count, and the wrong look or face would be painted. For all
    other options the last value counts, as people expect who add options to those of a script.
    """
    if ctx.resilient_parsing:  # true while a shell completes a line
        return
    args = args[: args.index("--")] if "--" in args else args
    single = {name for param in params if not param.multiple for name in param.opts}
    for name, takes in _GIVEN_ONCE.items():
        given = sum(word.partition("=")[0] == name for word in args)
        if name in single and given > 1:
            ctx.fail(f"{name} is given {given} times, and this command takes {takes}")


def _takes_colour(param: Any) -> bool:
    return str(param.metavar or "").startswith(COLOUR)


def usage_line(error: Any) -> str:
    """The line for one of Typer's usage errors.

    For a mistyped option the line names the option that was meant; for an option of other commands
    it names those commands.
    """
    ctx = getattr(error, "ctx", None)
    command = ctx.command.name if ctx and ctx.parent else DEFAULT
    if ctx and type(error).__name__ == "NoSuchOption":
        return with_help_pages(*_unknown_option(error.option_name, ctx, command))
    return with_help_pages(_message(error), [command])


def _message(error: Any) -> str:
    """What is wrong, in our words; in Typer's words for an error of any other kind."""
    kind, typers = type(error).__name__, " ".join(error.format_message().split())
    param = getattr(error, "param", None)
    if kind == "MissingParameter" and param is not None:
        return f"{_named(param)} is missing"
    if kind == "BadParameter" and param is not None:
        return _bad_value(error, param) or typers
    if kind == "BadOptionUsage":
        needs = "requires" in typers
        return f"{error.option_name} {'needs a value' if needs else 'takes no value'}"
    if extra := re.fullmatch(r"Got unexpected extra argument\S* \((.*)\)", typers):
        from makeup_video.pipeline.files.endings import PHOTOS

        words = extra[1].split()
        options = _options(error.ctx.command.params) if getattr(error, "ctx", None) else []
        if len(words) == 1 and words[0].lower().endswith(PHOTOS) and "--ref" in options:
            return f"too many arguments: {extra[1]}; the photo of a look is --ref {extra[1]}"
        if all(word.lower().endswith(".json") for word in words) and "--looks" in options:
            return f"too many arguments: {extra[1]}; quote a pattern, as in --looks 'looks/*.json'"
        several = "; makeup-video batch takes several inputs" if "--save-look" in options else ""
        return f"too many arguments: {extra[1]}{several}"
    return typers


def _bad_value(error: Any, param: Any) -> str | None:
    """The message about a value that is no number; None for any other error."""
    try:
        (found,) = error.__cause__.errors()
    except (AttributeError, TypeError, ValueError):
        return None
    kind = _KINDS.get(found["type"].partition("_")[0])
    return kind and f"{_named(param)} must be {kind}, got {found['input']!r}"


def _named(param: Any) -> str:
    """An option with all its names, such as "-o/--output"; an argument as the help shows it."""
    if param.param_type_name == "argument":
        return str(param.metavar)
    return "/".join(param.opts)


def _unknown_option(option: str, ctx: Any, command: str) -> tuple[str, list[str]]:
    """The message about an unknown option, and the commands whose help lists what was meant."""
    text = f"{as_typed(command)} has no option {option}"
    for word in sys.argv[1:]:
        if word.startswith("-") and os.path.isfile(word):
            return f"{text}: to name the file, write {shlex.quote('./' + word)}", [command]
    commands = ctx.find_root().command.commands
    owners = [name for name, other in commands.items() if option in _options(other.params)]
    if len(owners) > _FEW:
        return f"{text}: other commands have it", [command]
    if owners:
        return f"{text}: it is an option of {join_words([*map(as_typed, owners)])}", owners
    params = ctx.command.get_params(ctx)
    if command == DEFAULT:  # the page of this command lists the options of the group, too
        params += ctx.find_root().command.params
    names = {name.lstrip("-"): name for name in _options(params)}
    meant = closest(option.lstrip("-"), names)  # with hyphens, --foo would be close to --look
    return (f"{text}: did you mean {names[meant]}?" if meant else text), [command]


def _options(params: Iterable[Any]) -> list[str]:
    options = [param for param in params if param.param_type_name == "option"]
    return [name for param in options for name in (*param.opts, *param.secondary_opts)]
