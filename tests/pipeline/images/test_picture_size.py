"""Pictures of extreme size or shape: painted, or refused in one line before decoding."""

import struct
import zlib

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import (
    DecodeError,
    InputError,
    Look,
    OutputError,
    Settings,
    process_video,
    product,
)
from makeup_video.pipeline.files.output_file import part_path
from makeup_video.pipeline.images import picture_size
from picture_files import read_picture

LOOK = Look(lips=product((180, 0, 46), "satin"))


def png_head(width, height):
    """Return the start of a PNG of this size, without its pixels."""
    body = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = b"IDAT" + zlib.compress(bytes(100))
    parts = [
        struct.pack(">I", len(part) - 4) + part + struct.pack(">I", zlib.crc32(part))
        for part in (body, data)
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def jpeg_head(width, height):
    _, data = cv2.imencode(".jpg", np.zeros((8, 8, 3), np.uint8))
    data = data.tobytes()
    offset = data.index(b"\xff\xc0")
    return data[: offset + 5] + struct.pack(">HH", height, width) + data[offset + 9 :]


def webp_head(width, height):
    _, data = cv2.imencode(".webp", np.zeros((8, 8, 3), np.uint8), [cv2.IMWRITE_WEBP_QUALITY, 50])
    data = data.tobytes()
    offset = data.index(b"\x9d\x01\x2a") + 3  # RFC 6386, section 9.1
    return data[:offset] + struct.pack("<HH", width, height) + data[offset + 4 :]


def lossless_webp_head(width, height):
    """Return the start of a lossless WebP file (RFC 9649, section 3.4)."""
    bits = 0x2F | width - 1 << 8 | height - 1 << 22
    body = b"WEBPVP8L" + struct.pack("<I", 20) + bits.to_bytes(5, "little") + bytes(15)
    return b"RIFF" + struct.pack("<I", len(body)) + body


def extended_webp_head(width, height):
    """Return the start of an extended WebP file (RFC 9649, section 2.7)."""
    size = (width - 1).to_bytes(3, "little") + (height - 1).to_bytes(3, "little")
    body = b"WEBPVP8X" + struct.pack("<I", 10) + bytes(4) + size + bytes(20)
    return b"RIFF" + struct.pack("<I", len(body)) + body


@pytest.mark.parametrize(
    ("head", "size_wh", "words"),
    [
        (png_head, (11000, 11000), "11000 x 11000 px, .* 120 million px"),
        (png_head, (100_000, 100_000), "100000 x 100000 px, .* 120 million px"),
        (png_head, (2_000_000, 1), "2000000 x 1 px, .* 1000000 px in a row or column"),
        (png_head, (1, 2**31 - 1), "1 x 2147483647 px, .* 1000000 px in a row or column"),
        (jpeg_head, (65500, 65500), "65500 x 65500 px, .* 120 million px"),
        (webp_head, (16383, 16383), "16383 x 16383 px, .* 120 million px"),
        (lossless_webp_head, (16384, 12345), "16384 x 12345 px, .* 120 million px"),
        (extended_webp_head, (2**24, 2), "16777216 x 2 px, .* 1000000 px in a row or column"),
        (extended_webp_head, (2, 2**24), "2 x 16777216 px, .* 1000000 px in a row or column"),
    ],
)
def test_a_picture_that_is_too_large_is_refused_by_its_header(
    tmp_path, monkeypatch, head, size_wh, words, capfd
):
    monkeypatch.setattr(cv2, "imdecodeWithMetadata", lambda *_, **__: pytest.fail("decoded"))
    src = tmp_path / "in"
    src.write_bytes(head(*size_wh))
    with pytest.raises(DecodeError, match=words) as caught:
        process_video(src, tmp_path / "out.png", LOOK)
    assert caught.value.exit_code == 3 and "\n" not in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["in"] and capfd.readouterr().err == ""


@pytest.mark.parametrize("end", [".jpg", ".png", ".webp"])
@pytest.mark.parametrize("lossless", [False, True])
def test_the_header_gives_the_size_that_the_decoder_finds(tmp_path, monkeypatch, end, lossless):
    path = tmp_path / f"in{end}"
    blank = np.zeros((35, 77, 3), np.uint8)
    cv2.imwrite(str(path), blank, [cv2.IMWRITE_WEBP_QUALITY, 101 if lossless else 50])
    monkeypatch.setattr(picture_size, "MOST_PX", 35 * 77)
    assert read_picture(path)[0].shape[:2] == (35, 77)
    monkeypatch.setattr(picture_size, "MOST_PX", 35 * 77 - 1)
    with pytest.raises(DecodeError, match="77 x 35 px"):
        read_picture(path)


@pytest.mark.parametrize("shape", [(1, 1), (1, 100_000), (100_000, 1), (1, 2), (3, 70_001)])
@pytest.mark.parametrize("compare", [False, True])
def test_the_smallest_and_the_narrowest_are_painted(tmp_path, shape, compare):
    pixels = np.random.default_rng(0).integers(0, 255, (*shape, 3)).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "in.png"), pixels)
    report = process_video(
        tmp_path / "in.png", tmp_path / "out.png", LOOK, Settings(compare=compare)
    )
    assert "no face was found: nothing was painted" in report.warnings()[0]
    got = read_picture(tmp_path / "out.png")[0]
    np.testing.assert_array_equal(got, np.hstack([pixels] * 2) if compare else pixels)


@pytest.mark.parametrize(
    ("wide", "name", "compare", "words"),
    [
        (70_000, "out.jpg", False, "70000 x 1 px cannot be encoded as .jpg: choose .png"),
        (20_000, "out.webp", False, "20000 x 1 px cannot be encoded as .webp: choose .png"),
        (600_000, "out.png", True, "1200000 x 1 px cannot be encoded as .png: make it smaller"),
    ],
)
def test_a_picture_that_no_output_can_hold_is_one_line(tmp_path, wide, name, compare, words):
    cv2.imwrite(str(tmp_path / "in.png"), np.zeros((1, wide, 3), np.uint8))
    with pytest.raises(OutputError, match=words):
        process_video(tmp_path / "in.png", tmp_path / name, None, Settings(compare=compare))
    assert [path.name for path in tmp_path.iterdir()] == ["in.png"]


def test_a_side_by_side_picture_may_exceed_the_size_limit(tmp_path, monkeypatch):
    """The limit holds for the input alone: the product reads its own larger output back."""
    monkeypatch.setattr(picture_size, "MOST_PX", 40 * 60)
    exif = np.frombuffer(b"II*\0\x08\0\0\0\1\0\x12\1\3\0\1\0\0\0\1\0\0\0" + bytes(4), np.uint8)
    blank = np.zeros((40, 60, 3), np.uint8)
    _, data = cv2.imencodeWithMetadata(".png", blank, [int(cv2.IMAGE_METADATA_EXIF)], [exif])
    (tmp_path / "in.png").write_bytes(data.tobytes())
    src, dst = tmp_path / "in.png", tmp_path / "out.png"
    process_video(src, dst, None, Settings(compare=True))
    assert cv2.imread(str(tmp_path / "out.png")).shape == (40, 120, 3)


def test_a_file_larger_than_any_picture_is_not_read(tmp_path):
    path = tmp_path / "in.png"
    path.write_bytes(png_head(8, 8))
    with path.open("r+b") as file:
        file.truncate(3_000_000_000)  # sparse: takes no disk space
    with pytest.raises(InputError, match=r"in\.png cannot be read: it has more than 1000 MB"):
        process_video(path, tmp_path / "out.png")
    assert not part_path(tmp_path / "out.png").exists()
