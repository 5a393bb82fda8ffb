"""Mutations that know how videos are stored: atoms, elements, chunks, packets and tags."""

from collections.abc import Iterable, Sequence
from random import Random

from fuzz.mutate import NUMBERS, Mutation, number, put, swap

_ATOMS = tuple(
    b"moov mvhd trak tkhd edts elst mdia mdhd hdlr minf vmhd smhd dinf dref stbl stsd stts ctts "
    b"stsc stsz stss stco co64 sgpd sbgp udta meta ilst chpl mvex trex moof mfhd traf tfhd tfdt "
    b"trun mfra tfra mdat ftyp free wide avc1 hvc1 avcC hvcC esds mp4a alac ac-3 dac3 colr pasp "
    b"btrt sidx tmcd gmhd tx3g text apch fiel data name".split()
)
_ELEMENTS = tuple(
    bytes.fromhex(name.decode())
    for name in (
        b"1A45DFA3 18538067 114D9B74 1549A966 1654AE6B 1F43B675 1C53BB6B 1941A469 1043A770 "
        b"1254C367 AE E0 E1 B0 BA 54B0 54BA 2AD7B1 86 63A2 A3 A0 A1 E7 D7 83 4489 55B0 53B8 "
        b"53C0 5031 6240 7446 465C 466E 45B9 B6 91 92 6DE7 56AA 56BB 23E383 536E A6 EE A5 75A1"
    ).split()
)
_TOP_ELEMENTS = _ELEMENTS[2:10]
_CHUNKS = tuple(
    b"RIFF LIST avih strh strf hdrl strl movi idx1 indx INFO 00dc 01wb 00db JUNK odml dmlh vids "
    b"auds ISFT VP8X VP8L ANIM ANMF ALPH EXIF ICCP".split()
)
_PACKET_BYTES = 188


def atom_number(r: Random, data: bytes) -> bytes:
    """Change a number in an atom: a size, a count, a time, an offset."""
    changed = bytearray(data)
    for at in _drawn(r, _places(data, _ATOMS, 4)):
        size = int.from_bytes(data[at - 4 : at], "big")
        put(changed, at + 4 + 4 * r.randrange(max(1, min(size // 4, 24))), r.choice(NUMBERS), 4)
    return bytes(changed)


def atom_size(r: Random, data: bytes) -> bytes:
    changed = bytearray(data)
    for at in _drawn(r, _places(data, _ATOMS, 4)):
        near = int.from_bytes(data[at - 4 : at], "big") + r.randint(-64, 64)
        put(changed, at - 4, r.choice((max(0, near), r.choice(NUMBERS))), 4)
    return bytes(changed)


def atom_name(r: Random, data: bytes) -> bytes:
    changed = bytearray(data)
    for at in _drawn(r, _places(data, _ATOMS, 4)):
        changed[at : at + 4] = r.choice((b"free", b"\0\0\0\0", r.choice(_ATOMS)))
    return bytes(changed)


def atom_gone_or_twice(r: Random, data: bytes) -> bytes:
    places = _places(data, _ATOMS, 4)
    if not places:
        return number(r, data)
    at = r.choice(places) - 4
    end = at + max(8, int.from_bytes(data[at : at + 4], "big"))
    return data[:at] + data[at:end] * r.choice((0, 2)) + data[end:]


def atom_order(r: Random, data: bytes) -> bytes:
    parts, at = [], 0
    while at + 8 <= len(data):
        size = int.from_bytes(data[at : at + 4], "big")
        size = size if 8 <= size <= len(data) - at else len(data) - at
        parts.append(data[at : at + size])
        at += size
    r.shuffle(parts)
    return b"".join(parts)


def element_size(r: Random, data: bytes) -> bytes:
    changed = bytearray(data)
    for at in _drawn(r, _element_ends(r, data)):
        width = _width(data[at]) if at < len(data) else 8
        most = (1 << 7 * width) - 1
        value = r.choice((0, 1, most - 1, most, r.getrandbits(7 * width)))
        put(changed, at, 1 << 7 * width | value, width)
    return bytes(changed)


def element_number(r: Random, data: bytes) -> bytes:
    changed = bytearray(data)
    for at in _drawn(r, _element_ends(r, data)):
        width = _width(data[at]) if at < len(data) else 8
        put(changed, at + width + r.randrange(4), r.choice(NUMBERS), r.choice((1, 2, 4)))
    return bytes(changed)


def element_name(r: Random, data: bytes) -> bytes:
    places = _places(data, _ELEMENTS)
    if not places:
        return number(r, data)
    at = r.choice(places)
    other = r.choice(_ELEMENTS)
    return data[:at] + other + data[at + len(other) :]


def element_gone(r: Random, data: bytes) -> bytes:
    ends = [at for at in _element_ends(r, data) if at < len(data)]
    if not ends:
        return number(r, data)
    at = r.choice(ends)
    width = _width(data[at])
    size = int.from_bytes(data[at : at + width], "big") & (1 << 7 * width) - 1
    return data[: at - 1] + data[at + width + size :]


def element_order(r: Random, data: bytes) -> bytes:
    marks = _places(data, _TOP_ELEMENTS)
    if len(marks) < 2:
        return swap(r, data)
    parts = [data[a:b] for a, b in zip(marks, [*marks[1:], len(data)], strict=True)]
    r.shuffle(parts)
    return data[: marks[0]] + b"".join(parts)


def chunk(r: Random, data: bytes) -> bytes:
    """RIFF: change a size, a number or a name."""
    changed, what = bytearray(data), r.randrange(3)
    for at in _drawn(r, _places(data, _CHUNKS)):
        if what == 0:
            put(changed, at + 4, r.choice(NUMBERS), 4, "little")
        elif what == 1:
            put(changed, at + 8 + 4 * r.randrange(12), r.choice(NUMBERS), 4, "little")
        else:
            changed[at : at + 4] = r.choice(_CHUNKS)
    return bytes(changed)


def packet_order(r: Random, data: bytes) -> bytes:
    parts = _packets(data)
    for _ in range(r.choice((1, 5, 20, 4 * len(parts)))):
        a, b = r.randrange(len(parts)), r.randrange(len(parts))
        parts[a], parts[b] = parts[b], parts[a]
    return b"".join(parts)


def packets_gone_or_twice(r: Random, data: bytes) -> bytes:
    times = r.choice((0, 2))
    return b"".join(part * (times if r.random() < 0.1 else 1) for part in _packets(data))


def packet_head(r: Random, data: bytes) -> bytes:
    """Change a packet's programme number, counter or flags."""
    changed = bytearray(data)
    for at in range(0, len(data) - 3, _PACKET_BYTES):
        if r.random() < 0.1:
            changed[at + r.randrange(1, 4)] ^= 1 << r.randrange(8)
    return bytes(changed)


def tag(r: Random, data: bytes) -> bytes:
    """FLV: change a tag's kind, size or time, or delete or duplicate the tag."""
    tags, at = [], 13
    while at + 15 <= len(data):
        size = 15 + int.from_bytes(data[at + 1 : at + 4], "big")
        tags.append((at, size))
        at += size
    if not tags:
        return number(r, data)
    changed = bytearray(data)
    at, size = r.choice(tags)
    what = r.randrange(4)
    if what == 0:
        changed[at] = r.choice((8, 9, 18, r.randrange(256)))
    elif what < 3:  # size, then time
        put(changed, at + 1 + 3 * (what - 1), r.choice(NUMBERS), 3)
    else:
        return data[:at] + data[at : at + size] * r.choice((0, 2)) + data[at + size :]
    return bytes(changed)


_MP4 = (atom_number, atom_size, atom_name, atom_gone_or_twice, atom_order)
_MKV = (element_size, element_number, element_name, element_gone, element_order)
_TS = (packet_order, packets_gone_or_twice, packet_head)

OWN: dict[str, Sequence[Mutation]] = {
    ".mp4": _MP4, ".mov": _MP4, ".avif": _MP4, ".mkv": _MKV, ".webm": _MKV, ".avi": (chunk,),
    ".webp": (chunk,), ".ts": _TS, ".flv": (tag,),
}  # fmt: skip


def _places(data: bytes, names: Iterable[bytes], first: int = 0) -> list[int]:
    """Offsets of the names, from `first` on; of each name, only the first matches."""
    found = set()
    for name in names:
        at = data.find(name, first)
        for _ in range(64):
            if at < 0:
                break
            found.add(at)
            at = data.find(name, at + 1)
    return sorted(found)


def _drawn(r: Random, places: Sequence[int]) -> list[int]:
    return [r.choice(places) for _ in range(r.randint(1, 3))] if places else []


def _element_ends(r: Random, data: bytes) -> list[int]:
    """Offsets of element sizes. One-byte names match anywhere, so only a few of them are used."""
    names = [name for name in _ELEMENTS if len(name) > 1 or r.random() < 0.2]
    return [at + len(name) for name in names for at in _places(data, [name])]


def _width(first: int) -> int:
    """The length of an element's size in bytes, which its first byte encodes."""
    return 9 - first.bit_length() if first else 8


def _packets(data: bytes) -> list[bytes]:
    return [data[at : at + _PACKET_BYTES] for at in range(0, len(data), _PACKET_BYTES)]
