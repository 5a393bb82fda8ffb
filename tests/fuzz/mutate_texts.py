"""Mutations of look files and catalogues: of their grammar first, then of their bytes."""

import json
import sys
from collections.abc import Iterator
from copy import deepcopy
from random import Random
from typing import Any

from fuzz.mutate import GENERAL

_VALUES: tuple[Any, ...] = (
    None, True, False, -1, 2, 1e400, -1e400, float("nan"), 10**400, 10**5000, 1e308, 5e-324, -0.0,
    255.0000001, "", "lid", "x" * 10000, [], {}, [[]], {"a": 1}, "\ud800", "\0", "é" * 50, "1",
    0.5, 1, 256, -0.001,
)  # fmt: skip
_STRANGE = ("x", "Version", "", "lips ", "__class__", "red\n", "\x1b[31m", "\u202e")
_KNOWN = (
    "strength", "zone", "intensity", "lips", "eyes", "version", "red", "gloss",
    "layers", "kind", "product", "shape", "slot", "wing",
)  # fmt: skip
_TOKENS = (b"1e", b"0x10", b"+1", b".5", b"1.", b"01", b"--1", b"Infinity", b"'a'", b"")
_LINE_ENDS = (b"\r", b"\r\n", b"\n\n", b"\0\n", b"\x0b\n", "\u2028".encode())
_SIGNS = (b"", b"##", b"0x", "\uff03".encode(), b"-", b"\x1b")
_WHOLE = (
    b"", b"\xef\xbb\xbf", b",", b";", b'"', b"\0", b"brand,product,shade,hex",
    b"brand,product,shade,hex\n", b"hex,hex,brand,product,shade\n1,2,3,4,5\n",
)  # fmt: skip


def mutate_look(r: Random, data: bytes) -> tuple[bytes, str]:
    """A mutated look file, which mostly is still JSON, and the name of the mutation."""
    text = _spelled(r, _changed(r, json.loads(data)))
    what = r.choice(("", "", "", "bom", "encoding", "deep", "digits", "token", "twice", "bytes"))
    if what == "bom":
        text = b"\xef\xbb\xbf" + text
    elif what == "encoding":
        code = r.choice(("utf-16", "utf-32", "latin-1"))
        text = text.decode("utf-8", "replace").encode(code, "replace")
    elif what == "deep":
        nested = r.choice((b"[", b'{"a":')) * r.choice((900, 5000, 200_000))
        text = b'{"version":1,"lips":' + nested
    elif what == "digits":
        text = text.replace(b"1", b"1" * r.choice((5000, 100_000)), 1)
    elif what == "token":
        text = text.replace(b":", b":" + r.choice(_TOKENS) + b" ", r.choice((1, 3)))
    elif what == "twice":
        text = text.replace(b"{", b'{"lips":null,"lips":null,', 1)
    elif what == "bytes":
        text = r.choice(GENERAL)(r, text)
    return text, f"json: grammar {what}".rstrip()


def mutate_catalogue(r: Random, data: bytes) -> tuple[bytes, str]:
    """A mutated catalogue, and the name of the mutation."""
    what = r.choice(tuple(_CATALOGUES))
    return _CATALOGUES[what](r, data), f"csv: {what}"


def _changed(r: Random, look: dict[str, Any]) -> dict[str, Any]:
    for _ in range(r.randint(0, 4)):
        where = r.choice(list(_objects(look)))
        what = r.randrange(4)
        if what == 0 and where:
            where[r.choice(tuple(where))] = deepcopy(r.choice(_VALUES))
        elif what == 1 and where:
            del where[r.choice(tuple(where))]
        else:
            where[r.choice(_STRANGE if what == 2 else _KNOWN)] = deepcopy(r.choice(_VALUES))
    return look


def _objects(value: Any) -> Iterator[dict[str, Any]]:
    """Every object of a look, those of its layers too."""
    if isinstance(value, dict):
        yield value
    if isinstance(value, dict | list):
        for inner in value.values() if isinstance(value, dict) else value:
            yield from _objects(inner)


def _spelled(r: Random, look: dict[str, Any]) -> bytes:
    most = sys.get_int_max_str_digits()
    sys.set_int_max_str_digits(0)  # one value has more digits than Python writes by default
    try:
        text = json.dumps(look, ensure_ascii=r.random() < 0.5, indent=r.choice((None, 1)))
    finally:
        sys.set_int_max_str_digits(most)
    return text.encode("utf-8", "surrogatepass")


def _rows(r: Random, _: bytes) -> bytes:
    names = (b"=cmd()", b"\x1b[2J", "\u202e".encode(), b"a" * 5000)
    rows = (b"%06X,%s,b,c" % (r.getrandbits(24), r.choice(names)) for _ in range(50))
    return b"hex,shade,product,brand\n" + b"\n".join(rows)


def _recoded(r: Random, data: bytes) -> bytes:
    code = r.choice(("utf-16", "utf-32", "latin-1", "cp1252"))
    return data.decode("utf-8", "replace").encode(code, "replace")


def _shuffled(r: Random, data: bytes) -> bytes:
    lines = data.splitlines(keepends=True)
    r.shuffle(lines)
    return b"".join(lines)


_CATALOGUES = {
    "semicolons": lambda r, data: data.replace(b",", b";"),
    "encoding": _recoded,
    "open quote": lambda r, data: data + b'"' + b"x" * r.choice((10, 200_000, 3_000_000)),
    "line ends": lambda r, data: data.replace(b"\n", r.choice(_LINE_ENDS)),
    "columns": lambda r, data: (
        b"brand,product,shade,hex" + b",x" * r.choice((1, 99, 99_999)) + data
    ),
    "long": lambda r, data: data * r.choice((1, 50, 3000)),
    "signs": lambda r, data: data.replace(b"#", r.choice(_SIGNS)),
    "rows": _rows,
    "blank lines": lambda r, data: b"\n" * r.choice((1, 1000, 200_000)) + data,
    "next to nothing": lambda r, data: r.choice(_WHOLE),
    "order": _shuffled,
    "bytes": lambda r, data: r.choice(GENERAL)(r, data),
}
