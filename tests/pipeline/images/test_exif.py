"""EXIF blocks: the thumbnail is removed, all else stays, and damaged blocks do no harm."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import process_video
from makeup_video.pipeline.images.exif import without_thumbnail
from picture_files import EXIF, read_picture, scene, write
from PIL import Image

SMALL = b"\xff\xd8" + b"a face" * 9 + b"\xff\xd9"


def with_thumbnail(order: str, behind: bytes = b"") -> bytes:
    """A block with orientation 6 and a thumbnail, followed by the bytes `behind`."""
    mark, base = (b"II*\0" if order == "<" else b"MM\0*"), 8 + 18
    first = struct.pack(order + "HHHIHHI", 1, 0x0112, 3, 1, 6, 0, base)
    place = base + 2 + 24 + 4
    second = struct.pack(order + "H", 2) + struct.pack(order + "HHII", 0x0201, 4, 1, place)
    second += struct.pack(order + "HHII", 0x0202, 4, 1, len(SMALL)) + bytes(4)
    return mark + struct.pack(order + "I", 8) + first + second + SMALL + behind


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("header", [b"", b"Exif\0\0"])
@pytest.mark.parametrize("behind", [b"", b"more"])
def test_the_small_picture_goes_and_the_rest_stays(order, header, behind):
    block = header + with_thumbnail(order, behind)
    changed = without_thumbnail(block)
    assert SMALL not in changed and b"a face" not in changed
    assert len(changed) == len(block) - (0 if behind else len(SMALL))
    assert changed.endswith(behind)
    exif = Image.Exif()
    exif.load(changed)
    assert exif[0x0112] == 6 and not exif.get_ifd(0x0201)
    assert without_thumbnail(changed) == changed


@pytest.mark.parametrize("order", ["<", ">"])
def test_only_single_numbers_say_where_the_small_picture_lies(order):
    block = with_thumbnail(order, b"makernote")
    place = block.index(struct.pack(order + "HH", 0x0201, 4))
    # another tag instead of the thumbnail's offset, then an array instead of one number
    for at, part in ((place, b"\0\0"), (place + 4, struct.pack(order + "I", 2))):
        odd = block[:at] + part + block[at + len(part) :]
        assert without_thumbnail(odd)[26:] == odd[26:]
    length = struct.pack(order + "HHI", 0x0202, 3, 1) + struct.pack(order + "HH", len(SMALL), 0)
    at = block.index(struct.pack(order + "HH", 0x0202, 4))
    changed = without_thumbnail(block[:at] + length + block[at + 12 :])
    assert SMALL not in changed and changed.endswith(b"makernote")


@given(st.binary(max_size=80) | st.binary(max_size=60).map(lambda data: b"II*\0\x08\0\0\0" + data))
def test_any_bytes_stay_as_long_or_become_shorter(data):
    assert len(without_thumbnail(data)) <= len(data)


@pytest.mark.parametrize("end", [".jpg", ".png", ".webp"])
def test_a_painted_picture_shows_no_unpainted_small_one(tmp_path, end):
    src = write(tmp_path / "in.jpg", scene(), {EXIF: with_thumbnail("<")})
    report = process_video(src, tmp_path / f"out{end}")
    assert SMALL not in (tmp_path / f"out{end}").read_bytes() and report.dropped == []
    block = read_picture(tmp_path / f"out{end}")[1][EXIF]
    assert struct.pack("<HHIHH", 0x0112, 3, 1, 6, 0) in block
