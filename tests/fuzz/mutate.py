"""Random damage to a file; a generator in the same state does the same damage."""

import math
from collections.abc import Callable, Sequence
from pathlib import PurePath
from random import Random

Mutation = Callable[[Random, bytes], bytes]

# Limits at which programs count, compare or allocate wrongly.
NUMBERS = (
    0, 1, 2, 3, 4, 7, 8, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 0x10000, 0x1000000,
    0x10000000, 0x40000000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF,
)  # fmt: skip
_MOST_BYTES = 4_000_000  # a mutated file is cut to this size
_HEAD = 4096  # bytes in which most formats describe the rest of the file


def some(r: Random, low: int, high: int) -> int:
    """A number in low..high, small ones as likely as large ones."""
    return round(math.exp(r.uniform(math.log(low), math.log(max(low, high)))))


def put(data: bytearray, at: int, value: int, width: int, order: str = "big") -> None:
    """Overwrite `width` bytes with a number, if they lie within the data."""
    if 0 <= at <= len(data) - width:
        low = value & (256**width - 1)
        data[at : at + width] = low.to_bytes(width, "big" if order == "big" else "little")


def flip_many(r: Random, data: bytes) -> bytes:
    changed = bytearray(data)
    near = min(len(data), _HEAD) if r.random() < 0.35 else len(data)
    for _ in range(some(r, 1, 1000)):
        at = r.randrange(near) if r.random() < 0.85 else -1 - r.randrange(min(len(data), _HEAD))
        changed[at] = changed[at] ^ 1 << r.randrange(8) if r.random() < 0.6 else r.randrange(256)
    return bytes(changed)


def flip_few(r: Random, data: bytes) -> bytes:
    changed = bytearray(data)
    for _ in range(r.randint(1, 6)):
        at = r.randrange(min(len(data), r.choice((256, 1024, _HEAD, len(data)))))
        changed[at] ^= 1 << r.randrange(8)
    return bytes(changed)


def cut(r: Random, data: bytes) -> bytes:
    tail = len(data) - some(r, 1, max(2, len(data) // 2))
    return data[: max(1, r.choice((some(r, 1, len(data)), r.randrange(len(data)), tail)))]


def fill(r: Random, data: bytes) -> bytes:
    at, count = _span(r, data)
    return data[:at] + r.choice((b"\0", b"\xff", b"\x80")) * count + data[at + count :]


def duplicate(r: Random, data: bytes) -> bytes:
    at, count = _span(r, data)
    return data[:at] + data[at : at + count] * r.choice((1, 1, 2, 20)) + data[at:]


def drop(r: Random, data: bytes) -> bytes:
    at, count = _span(r, data)
    return data[:at] + data[at + count :]


def swap(r: Random, data: bytes) -> bytes:
    a, b = sorted((r.randrange(len(data)), r.randrange(len(data))))
    n = max(1, min(some(r, 1, len(data)), b - a, len(data) - b))
    return data[:a] + data[b : b + n] + data[a + n : b] + data[a : a + n] + data[b + n :]


def number(r: Random, data: bytes) -> bytes:
    changed = bytearray(data)
    for _ in range(r.randint(1, 4)):
        at = r.randrange(min(len(data), r.choice((64, 512, _HEAD, len(data)))))
        order = r.choice(("big", "little"))
        put(changed, at, r.choice(NUMBERS), r.choice((1, 2, 4, 4, 8)), order)
    return bytes(changed)


def noise(r: Random, data: bytes) -> bytes:
    at, count = r.randrange(len(data)), some(r, 1, _HEAD)
    return data[:at] + r.randbytes(count) + data[at + r.choice((0, count)) :]


GENERAL = (flip_many, flip_few, cut, fill, duplicate, drop, swap, number, noise)


def mutate(
    r: Random, name: str, data: bytes, others: Sequence[bytes], own: Sequence[Mutation]
) -> tuple[bytes, str]:
    """The damaged file and the names of the mutations.

    others: whole files, whose end may replace the end of this file.  own: mutations that know the
    file's format; they are about as frequent as the general ones.
    """
    if r.random() < 0.03:
        other = r.choice(others)
        return data[: r.randrange(len(data))] + other[r.randrange(len(other)) :], "splice"
    names = []
    weight = max(1, len(GENERAL) // max(1, len(own)))
    for _ in range(r.choice((1, 1, 1, 2, 3))):
        mutation = r.choice((*GENERAL, *(tuple(own) * weight)))
        data = mutation(r, data)[:_MOST_BYTES] or b"\0"
        names.append(mutation.__name__)
    return data, f"{PurePath(name).suffix[1:]}: {', '.join(names)}"


def _span(r: Random, data: bytes) -> tuple[int, int]:
    """(start, length) of a random piece, in bytes."""
    at = r.randrange(len(data))
    return at, min(some(r, 1, max(2, len(data) // 2)), len(data) - at)
