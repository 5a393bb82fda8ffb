"""A plain error for whoever sets an attribute of a frozen dataclass."""

from collections.abc import Callable
from dataclasses import FrozenInstanceError
from typing import NoReturn, TypeVar

_Class = TypeVar("_Class")


def unchangeable(advice: str) -> Callable[[type[_Class]], type[_Class]]:
    """A decorator above a frozen dataclass with slots: setting an attribute raises a plain error.

    advice: what to do instead. Python's own refusal of a property or a mistyped name is a TypeError
    about `super`.
    """

    def decorate(cls: type[_Class]) -> type[_Class]:
        def refuse(self: object, name: str, value: object) -> NoReturn:
            raise FrozenInstanceError(f"{name} of a {cls.__name__} cannot be set: {advice}")

        cls.__setattr__ = refuse  # type: ignore[method-assign]
        return cls

    return decorate
