"""Resolution, texts, comments and colour marks, as Pillow reads them from the written file."""

import struct
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Settings, StrictError, process_video
from makeup_video.pipeline.images.file_tags import FileTags, file_tags, with_file_tags
from makeup_video.pipeline.images.jpeg_segments import segment
from picture_files import exif, scene, write
from PIL import Image, IptcImagePlugin, PngImagePlugin

KINDS = {".png": "png", ".jpg": "jpeg", ".webp": "webp"}


def chunk(name, content):
    sum_ = struct.pack(">I", zlib.crc32(name + content))
    return struct.pack(">I", len(content)) + name + content + sum_


def png_with(path, *chunks):
    data = write(path, scene()).read_bytes()
    path.write_bytes(data[:33] + b"".join(chunks) + data[33:])
    return path


def info_of(path):
    with Image.open(path) as picture:
        picture.load()
        return picture.info


@pytest.mark.parametrize("start", [".png", ".jpg"])
@pytest.mark.parametrize("end", [".png", ".jpg", ".webp"])
@pytest.mark.parametrize("dpi", [(300, 300), (72, 144)])
def test_the_resolution_of_prints_is_kept_or_reported(tmp_path, start, end, dpi):
    src, dst = tmp_path / f"in{start}", tmp_path / f"out{end}"
    Image.fromarray(scene()).save(src, dpi=dpi)
    report = process_video(src, dst)
    if end == ".webp":
        assert report.dropped == ["resolution: not accepted in .webp"]
    else:
        assert report.dropped == []
        assert info_of(dst)["dpi"] == pytest.approx(dpi, abs=0.02)


@pytest.mark.parametrize(
    ("per_metre", "density"), [((10, 10), (1, 1, 1)), ((0, 0), (0, 1, 1)), ((0, 99), (0, 1, 1))]
)
def test_a_jpeg_never_has_a_density_of_0(tmp_path, per_metre, density):
    src = png_with(tmp_path / "in.png", chunk(b"pHYs", struct.pack(">IIB", *per_metre, 1)))
    process_video(src, tmp_path / "out.jpg")
    assert struct.unpack(">BHH", (tmp_path / "out.jpg").read_bytes()[13:18]) == density


@pytest.mark.parametrize("end", [".png", ".jpg", ".webp"])
@pytest.mark.parametrize(
    ("mode", "was"), [("P", "palette"), ("LA", "grey"), ("L", ""), ("RGB", "")]
)
def test_what_is_read_as_rgb_has_a_line(tmp_path, mode, was, end):
    Image.fromarray(scene()).convert(mode).save(tmp_path / "in.png")
    assert file_tags((tmp_path / "in.png").read_bytes()).conversions == (f"{was} -> RGB",) * bool(
        was
    )
    if was:
        with pytest.raises(StrictError, match=rf"{was} -> RGB.*\. Leave strict out\.$"):
            process_video(tmp_path / "in.png", tmp_path / f"out{end}", None, Settings(strict=True))


def test_a_transparent_tone_of_grey_has_a_line(tmp_path):
    Image.fromarray(scene()).convert("L").save(tmp_path / "in.png", transparency=5)
    report = process_video(tmp_path / "in.png", tmp_path / "out.png")
    assert [line.split(":")[0] for line in report.dropped] == ["transparency"]


@pytest.mark.parametrize("dpi", [72, 96])
def test_a_resolution_that_programs_invent_is_no_loss(tmp_path, dpi):
    Image.fromarray(scene()).save(tmp_path / "in.jpg", dpi=(dpi, dpi))
    assert process_video(tmp_path / "in.jpg", tmp_path / "out.webp").dropped == []


def test_texts_of_a_png_are_kept(tmp_path):
    texts = PngImagePlugin.PngInfo()
    texts.add_text("Author", "Jane")
    texts.add_itxt("Title", "Grüße")
    texts.add_text("Comment", "long " * 99, zip=True)
    Image.fromarray(scene()).save(tmp_path / "in.png", pnginfo=texts)
    assert process_video(tmp_path / "in.png", tmp_path / "out.png").dropped == []
    assert info_of(tmp_path / "out.png") == info_of(tmp_path / "in.png")
    report = process_video(tmp_path / "in.png", tmp_path / "out.jpg")
    assert report.dropped == ["texts: not accepted in .jpg"]


def test_old_copies_of_exif_in_texts_are_left_out(tmp_path):
    """They would still show the thumbnail of the unpainted face."""
    block = b"Exif\0\0" + exif(1)
    text = b"\nexif\n%8d\n%s\n" % (len(block), block.hex().encode())
    old = chunk(b"zTXt", b"Raw profile type exif\0\0" + zlib.compress(text))
    process_video(png_with(tmp_path / "in.png", old), tmp_path / "out.png")
    assert b"Raw profile" not in (tmp_path / "out.png").read_bytes()


def test_comments_of_a_jpeg_are_kept(tmp_path):
    Image.fromarray(scene()).save(tmp_path / "in.jpg", comment=b"by Jane")
    assert process_video(tmp_path / "in.jpg", tmp_path / "out.jpg").dropped == []
    assert info_of(tmp_path / "out.jpg")["comment"] == b"by Jane"
    report = process_video(tmp_path / "in.jpg", tmp_path / "out.png")
    assert report.dropped == ["comment: not accepted in .png"]


def resource(number, data, name=b""):
    """A Photoshop resource, its name and its data each padded to an even number of bytes."""
    named = (bytes([len(name)]) + name).ljust((len(name) + 2) // 2 * 2, b"\0")
    padded = data + bytes(len(data) % 2)
    return b"8BIM" + struct.pack(">H", number) + named + struct.pack(">I", len(data)) + padded


CAPTION = b"\x1c\x02\x78\x00\x07by Jane"  # IPTC record 2, data set 120: caption
SMALL_PICTURE = resource(0x040C, b"the face as it was")


@pytest.mark.parametrize("name", [b"", b"a", b"ab"])
@pytest.mark.parametrize("in_two", [False, True])
def test_iptc_of_a_jpeg_is_kept_without_the_small_picture(tmp_path, name, in_two):
    data = SMALL_PICTURE + resource(0x0404, CAPTION, name) + resource(0x03ED, bytes(16))
    parts = [data[:50], data[50:]] if in_two else [data]
    blocks = (segment(0xED, b"Photoshop 3.0\0" + part) for part in parts)
    plain = write(tmp_path / "in.jpg", scene()).read_bytes()
    (tmp_path / "in.jpg").write_bytes(plain[:20] + b"".join(blocks) + plain[20:])
    assert process_video(tmp_path / "in.jpg", tmp_path / "out.jpg").dropped == []
    with Image.open(tmp_path / "out.jpg") as picture:
        assert IptcImagePlugin.getiptcinfo(picture) == {(2, 120): b"by Jane"}
    assert b"the face as it was" not in (tmp_path / "out.jpg").read_bytes()
    report = process_video(tmp_path / "in.jpg", tmp_path / "out.png")
    assert report.dropped == ["IPTC: not accepted in .png"]


@pytest.mark.parametrize("mark", [b"8BIM", b"MeSa"])
def test_iptc_behind_other_marks_is_kept_and_long_one_named(tmp_path, mark):
    plain = write(tmp_path / "in.jpg", scene()).read_bytes()
    for size, dropped in ((20, []), (70_000, ["IPTC: it is longer than 64 kB"])):
        data = mark + SMALL_PICTURE[4:] + resource(0x0404, CAPTION + bytes(size))
        parts = (data[at : at + 60_000] for at in range(0, len(data), 60_000))
        blocks = b"".join(segment(0xED, b"Photoshop 3.0\0" + part) for part in parts)
        (tmp_path / "in.jpg").write_bytes(plain[:20] + blocks + plain[20:])
        assert process_video(tmp_path / "in.jpg", tmp_path / "out.jpg").dropped == dropped
        assert (CAPTION in (tmp_path / "out.jpg").read_bytes()) == (not dropped)
        (tmp_path / "out.jpg").unlink()


@given(st.binary(max_size=60))
def test_any_resources_of_photoshop_are_read_or_passed_over(noise):
    block = segment(0xED, b"Photoshop 3.0\0" + SMALL_PICTURE + b"8BIM" + noise)
    assert set(file_tags(b"\xff\xd8" + block).names) <= {"IPTC"}


def test_extended_xmp_of_a_jpeg_has_a_line(tmp_path):
    data = write(tmp_path / "in.jpg", scene()).read_bytes()
    more = segment(0xE1, b"http://ns.adobe.com/xmp/extension/\0" + bytes(60))
    (tmp_path / "in.jpg").write_bytes(data[:20] + more + data[20:])
    report = process_video(tmp_path / "in.jpg", tmp_path / "out.jpg")
    assert report.dropped == ["extended XMP: the first 64 kB are written alone"]


@pytest.mark.parametrize("kind", [b"iptc", b"8bim"])
def test_iptc_in_a_text_of_a_png_has_a_line(tmp_path, kind):
    old = chunk(b"zTXt", b"Raw profile type %b\0\0" % kind + zlib.compress(b"\niptc\n"))
    report = process_video(png_with(tmp_path / "in.png", old), tmp_path / "out.png")
    assert report.dropped == ["IPTC: it is not read from a PNG"]


MARKS = {
    "gamma": chunk(b"gAMA", struct.pack(">I", 100000)),
    "primaries": chunk(b"cHRM", struct.pack(">8I", *range(8))),
    "code of its colours": chunk(b"cICP", bytes([12, 13, 0, 1])),
    "": chunk(b"sRGB", b"\0"),
}


@pytest.mark.parametrize("name", MARKS)
def test_marks_of_a_pngs_colours_are_kept_once(tmp_path, name):
    src = png_with(tmp_path / "in.png", MARKS[name])
    for end in KINDS:
        report = process_video(src, tmp_path / f"out{end}")
        is_lost = name and end != ".png"
        assert report.dropped == ([f"{name}: not accepted in {end}"] if is_lost else [])
    assert (tmp_path / "out.png").read_bytes().count(MARKS[name]) == 1


@given(data=st.binary(max_size=120), kind=st.sampled_from(["\x89PNG\r\n\x1a\n", "\xff\xd8", ""]))
def test_any_bytes_have_tags_or_none(data, kind):
    tags = file_tags(kind.encode("latin-1") + data)
    assert isinstance(tags, FileTags) and bool(tags.kind) == bool(kind or tags.kind)


@pytest.mark.parametrize("end", KINDS)
def test_without_tags_a_file_stays_as_it_is(tmp_path, end):
    data = write(tmp_path / f"a{end}", scene()).read_bytes()
    assert with_file_tags(data, KINDS[end], FileTags("")) == (data, [])
