"""What Python defines and the kernels share: constants, and the layouts of structs and buffers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import prod

import numpy as np

_C_TYPES = {np.dtype(np.float32): "float", np.dtype(np.int32): "int"}
_NUMBER_BYTES = 4  # of every number in a struct, so that C needs no padding anywhere


@dataclass(frozen=True, slots=True, eq=False)
class Definitions:
    """The constants and structs of a kernel file. `+` adds those of a file that it includes.

    constants: macros by name.  structs: layouts by their C name; a struct comes after those that it
    contains.
    """

    constants: Mapping[str, int | float] = field(default_factory=dict)
    structs: Mapping[str, np.dtype] = field(default_factory=dict)

    def __add__(self, other: "Definitions") -> "Definitions":
        return Definitions({**self.constants, **other.constants}, {**self.structs, **other.structs})

    def options(self) -> list[str]:
        """Return -D options, with enough digits for every bit of a float32."""
        return [f"-D{name}={_literal(value)}" for name, value in self.constants.items()]

    def source(self) -> str:
        """The structs in C. Raises TypeError for a layout that a C struct would not have."""
        return "".join(
            f"typedef struct {{ {' '.join(self._members(layout))} }} {name};\n"
            for name, layout in self.structs.items()
        )

    def _members(self, layout: np.dtype) -> list[str]:
        members, end = [], 0
        for name, (kind, offset, *_) in (layout.fields or {}).items():
            base, shape = kind.subdtype or (kind, ())
            if offset != end or (base.fields is None and base.itemsize != _NUMBER_BYTES):
                raise TypeError(f"{name} of {layout} is not a packed number of four bytes")
            end = offset + kind.itemsize
            members.append(f"{self._c_type(base)} {name}{f'[{prod(shape)}]' if shape else ''};")
        return members

    def _c_type(self, base: np.dtype) -> str:
        for name, layout in self.structs.items():
            if layout is base or layout == base:
                return name
        if base not in _C_TYPES:
            raise TypeError(f"{base} has no C type in a struct of the kernels")
        return _C_TYPES[base]


def offsets(layout: np.dtype) -> dict[str, int]:
    """NAME_AT for each field of a layout of float32: where the field begins, counted in floats."""
    return {
        f"{name.upper()}_AT": offset // _NUMBER_BYTES
        for name, (_, offset, *_) in (layout.fields or {}).items()
    }


def floats(layout: np.dtype) -> int:
    """The size of a layout of float32, counted in floats."""
    return layout.itemsize // _NUMBER_BYTES


def _literal(value: float) -> str:
    return str(value) if isinstance(value, int) else f"({float(value)!r}f)"
