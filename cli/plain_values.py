"""Converts options that are plain text or numbers without pydantic, whose import takes time."""

import re
from collections.abc import Callable
from typing import Any

_NUMBERS = {
    int: re.compile(r"-?[0-9]{1,9}"),
    float: re.compile(r"-?[0-9]{1,9}(\.[0-9]{1,9})?"),
}


class PlainValues:
    """Converts the value of one option, in place of Typer's converter.

    Typer converts all values with pydantic, even those of options that are not given. Importing
    pydantic takes 60 ms. This class leaves to Typer only values that are neither text nor a plain
    number.  typers: returns Typer's converter of the option.
    """

    def __init__(self, typers: Callable[[], Any]) -> None:
        self._typers = typers

    def __call__(self) -> "PlainValues":
        """Called in place of the option's `get_runtime_param`."""
        return self

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        """The value of an option that was given this word, these words, a default, or nothing."""
        is_list = param.multiple or param.nargs == -1
        kind = param.type_descriptor.annotation
        if value is None:
            return () if is_list else None
        if is_list and kind == list[str] and all(type(word) is str for word in value):
            return list(value)
        if not is_list and not param.type_descriptor.is_ranged:
            if kind in (str, *_NUMBERS) and type(value) is kind:
                return value
            if kind in _NUMBERS and type(value) is str and _NUMBERS[kind].fullmatch(value):
                return kind(value)
        return self._typers().coerce(value, param=param, ctx=ctx)


def take_plain_values(params: list[Any]) -> None:
    """Convert plain values of these parameters without pydantic.

    Does nothing under a version of Typer whose parameters have no `get_runtime_param`.
    """
    for param in params:
        typers = getattr(param, "get_runtime_param", None)
        if typers is not None and not isinstance(typers, PlainValues):
            param.get_runtime_param = PlainValues(typers)
