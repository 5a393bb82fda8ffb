"""The segments of JPEG photos: profiles, gain maps, further pictures, four components."""

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from icc_profiles import DISPLAY_P3, SRGB_CURVE, profile
from makeup_video.pipeline import Settings, StrictError, process_video
from makeup_video.pipeline.images import file_tags, jpeg_segments
from makeup_video.pipeline.images.file_tags import without_announcements
from makeup_video.pipeline.images.jpeg_segments import (
    behind_picture,
    segment,
    segments,
    with_icc_profile,
)
from makeup_video.pipeline.offline.picture import open_picture
from picture_files import XMP, read_picture, scene
from PIL import Image

P3 = profile(DISPLAY_P3, SRGB_CURVE)
# A profile of 150 kB, as one with large tables has; no two of its segments are equal.
LARGE = (len(P3) + 150_000).to_bytes(4, "big") + P3[4:] + bytes(range(250)) * 600
GAIN_MAP = segment(0xE2, b"urn:iso:std:iso:ts:21496:-1\0\0\0\0\0")
FLASHPIX = segment(0xE2, b"FPXR\0\0\1\0\2" + bytes(40))
INDEX = segment(0xE2, b"MPF\0II*\0\x08\0\0\0" + bytes(60))
XMP_MARK = b"http://ns.adobe.com/xap/1.0/\0"
ANNOUNCED = b"""<rdf:Description xmlns:hdrgm="http://ns.adobe.com/hdr-gain-map/1.0/"
 xmp:Rating="5" hdrgm:Version="1.0" GCamera:MotionPhoto='1'>%b<dc:format>image/jpeg</dc:format>
</rdf:Description>"""
CONTAINER = b"""<Container:Directory><rdf:Seq><rdf:li><Container:Item Item:Length="9"/></rdf:li>
<rdf:li><Container:Item Item:Semantic="GainMap"></Container:Item></rdf:li></rdf:Seq>
</Container:Directory>"""


def jpeg(mode="RGB", **options):
    written = io.BytesIO()
    Image.fromarray(scene((64, 96, 3))).convert(mode).save(written, "jpeg", **options)
    return written.getvalue()


def parts_of(data):
    size = 65519
    starts = range(0, len(data), size)
    return [
        segment(0xE2, b"ICC_PROFILE\0" + bytes([number, len(starts)]) + data[at : at + size])
        for number, at in enumerate(starts, 1)
    ]


def photo(path, *blocks, behind=b"", mode="RGB"):
    data = jpeg(mode)
    path.write_bytes(data[:2] + b"".join(blocks) + data[2:] + behind)
    return path


def profile_of(path):
    with Image.open(path) as picture:
        return picture.info.get("icc_profile")


@pytest.mark.parametrize("blocks", [
    [*parts_of(P3), INDEX], [INDEX, *parts_of(P3)], [GAIN_MAP, *parts_of(P3), INDEX],
    [FLASHPIX, *parts_of(P3)], [b"\xff\xff" + parts_of(P3)[0], FLASHPIX],
])  # fmt: skip
@pytest.mark.parametrize("end", [".jpg", ".png", ".webp"])
def test_a_profile_beside_other_segments_is_kept(tmp_path, blocks, end):
    src = photo(tmp_path / "in.jpg", *blocks)
    assert open_picture(src).frame.tags.primaries == 12
    report = process_video(src, tmp_path / f"out{end}")
    assert report.dropped == [] and profile_of(tmp_path / f"out{end}") == P3


@pytest.mark.parametrize("block", [GAIN_MAP, FLASHPIX, INDEX])
def test_no_other_segment_is_taken_for_a_profile(tmp_path, block):
    src = photo(tmp_path / "in.jpg", block)
    assert process_video(src, tmp_path / "out.jpg").dropped == []
    assert profile_of(tmp_path / "out.jpg") is None


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("end", [".jpg", ".png"])
def test_a_profile_of_many_segments_is_kept(tmp_path, order, end):
    src = photo(tmp_path / "in.jpg", *parts_of(LARGE)[::order])
    assert process_video(src, tmp_path / f"out{end}").dropped == []
    assert profile_of(tmp_path / f"out{end}") == LARGE


def test_a_profile_of_too_many_segments_is_left_out():
    data = jpeg()
    whole = with_icc_profile(data, bytes(255 * 65519))
    assert sum(marker == 0xE2 for marker, _ in segments(whole)) == 255
    assert with_icc_profile(data, bytes(255 * 65519 + 1)) == data


@pytest.mark.parametrize("end", [".jpg", ".png"])
@pytest.mark.parametrize(
    ("block", "name"),
    [
        (GAIN_MAP, "gain map of HDR"),
        (segment(0xE1, XMP_MARK + ANNOUNCED % b""), "gain map of HDR"),
        (INDEX, "further pictures or a movie"),
        (b"", "further pictures or a movie"),
    ],
)
def test_what_lies_behind_the_picture_is_named(tmp_path, block, name, end):
    src = photo(tmp_path / "in.jpg", block, behind=jpeg())
    (line,) = process_video(src, tmp_path / f"out{end}").dropped
    assert line.startswith(f"{name}: ")
    written = (tmp_path / f"out{end}").read_bytes()
    assert behind_picture(segments(written)) == b"" or end == ".png"
    with pytest.raises(StrictError, match=name):
        process_video(src, tmp_path / f"strict{end}", None, Settings(strict=True))


def test_data_of_a_camera_behind_the_picture_is_named(tmp_path):
    src = photo(tmp_path / "in.jpg", INDEX, behind=b"Image_UTC_Data1753" * 9 + b"SEFT")
    (line,) = process_video(src, tmp_path / "out.jpg").dropped
    assert line.startswith("data of the camera: 0.2 kB behind the picture")


@pytest.mark.parametrize("behind", [b"", bytes(5000), b"\r\n"])
def test_padding_behind_the_picture_is_no_loss(tmp_path, behind):
    src = photo(tmp_path / "in.jpg", INDEX, behind=behind)
    assert process_video(src, tmp_path / "out.jpg").dropped == []


@pytest.mark.parametrize("elements", [b"", CONTAINER, CONTAINER * 2])
def test_xmp_announces_no_gain_map_that_is_gone(tmp_path, elements):
    src = photo(tmp_path / "in.jpg", segment(0xE1, XMP_MARK + ANNOUNCED % elements))
    for end in (".jpg", ".png", ".webp"):
        process_video(src, tmp_path / f"out{end}")
        xmp = read_picture(tmp_path / f"out{end}")[1][XMP]
        assert b" hdrgm:" not in xmp and b"Container:" not in xmp and b"GCamera:" not in xmp
        assert b'xmp:Rating="5"' in xmp and b"<dc:format>image/jpeg</dc:format>" in xmp
        assert b"</rdf:Description>" in xmp


def test_xmp_announces_no_more_xmp_that_is_gone():
    note = b'<rdf:Description xmpNote:HasExtendedXMP="0A1B" xmp:Rating="5"/>'
    assert without_announcements(note) == b'<rdf:Description xmp:Rating="5"/>'


def test_xmp_without_announcements_stays_as_it_is():
    xmp = (ANNOUNCED % CONTAINER).replace(b"hdrgm:Version", b"xmp:Version")
    xmp = xmp.replace(b"Container:", b"Other:").replace(b"Item:", b"It:").replace(b"GCamera", b"G")
    assert without_announcements(xmp) == xmp


@pytest.mark.parametrize("end", [".jpg", ".png", ".webp"])
def test_four_components_become_three_with_a_line(tmp_path, end):
    src = photo(tmp_path / "in.jpg", mode="CMYK")
    assert process_video(src, tmp_path / f"out{end}").conversions == ["CMYK -> RGB"]
    with pytest.raises(StrictError, match="CMYK -> RGB"):
        process_video(src, tmp_path / f"strict{end}", None, Settings(strict=True))


@pytest.mark.parametrize("progressive", [False, True])
def test_the_end_is_found_behind_every_scan(progressive):
    data = jpeg(progressive=progressive, comment=b"\xff\xd9")
    assert behind_picture(segments(data + b"behind")) == b"behind"
    assert behind_picture(segments(data[:-2])) == b""


def test_the_segments_of_a_photo_are_searched_once(tmp_path, monkeypatch):
    whole = []

    def counted(data):
        yield from segments(data)
        whole.append(len(data))

    monkeypatch.setattr(file_tags, "segments", counted)
    monkeypatch.setattr(jpeg_segments, "segments", counted)
    path = photo(tmp_path / "in.jpg", GAIN_MAP, *parts_of(P3), behind=jpeg("CMYK"))
    assert open_picture(path).frame.tags.primaries == 12
    assert whole == [path.stat().st_size]  # the profile search stops before the pixels


@given(st.binary(max_size=200))
def test_any_bytes_have_segments_or_none(noise):
    found = list(segments(b"\xff\xd8" + noise))
    assert sum(len(content) + 2 for _, content in found) <= len(noise)
