"""Picture files painted: what is kept, what is reported, what is refused."""

import struct
import zlib
from fractions import Fraction

import av
import cv2
import numpy as np
import pytest
from heif_files import heic
from icc_profiles import DISPLAY_P3, SRGB_CURVE, profile
from makeup_video.kernels.colour import SRGB, from_srgb_primaries, to_encoded, to_linear
from makeup_video.pipeline import (
    DecodeError,
    Look,
    OutputError,
    Settings,
    StrictError,
    UsageError,
    process_video,
    product,
)
from makeup_video.pipeline.frames.rgb import to_frame
from makeup_video.pipeline.images.exif import orientation as exif_orientation
from media import picture
from people import portrait
from picture_files import EXIF, ICC, XMP, exif, read_picture, scene, write
from PIL import Image

# An RGB display profile with one text tag (ICC.1, section 7). The text is noise because libpng
# rejects profiles whose compressed form is very small.
PROFILE = (
    struct.pack(">I4s4s4s4s4s", 600, b"lcms", b"\2\x10\0\0", b"mntr", b"RGB ", b"XYZ ")
    + bytes(12) + b"acsp" + bytes(28) + struct.pack(">III", 0xF6D6, 0x10000, 0xD32D) + bytes(48)
    + struct.pack(">I4sII4s", 1, b"cprt", 144, 456, b"text")
    + np.random.default_rng(1).bytes(452)
)  # fmt: skip


@pytest.mark.parametrize(
    ("shape", "dtype"),
    [((40, 60, 3), np.uint8), ((41, 63, 4), np.uint8), ((40, 60, 1), np.uint8),
     ((40, 60, 3), np.uint16), ((7, 5, 4), np.uint16), ((1, 1, 3), np.uint8)],
)  # fmt: skip
def test_an_unpainted_png_keeps_every_pixel(tmp_path, shape, dtype):
    pixels = scene(shape, dtype)
    src = write(tmp_path / "in.png", pixels)
    report = process_video(src, tmp_path / "out.png")
    got, _ = read_picture(tmp_path / "out.png")
    np.testing.assert_array_equal(got, pixels)
    assert (report.frames_in, report.frames_out) == (1, 1) and "one picture" in report.summary()


@pytest.mark.parametrize("start", [".jpg", ".png", ".webp"])
@pytest.mark.parametrize("end", [".jpg", ".jpeg", ".png", ".webp"])
def test_exif_icc_and_xmp_stay_and_nothing_is_turned(tmp_path, start, end):
    metadata = {EXIF: exif(6), ICC: PROFILE, XMP: b"<x:xmpmeta xmlns:x='adobe:ns:meta/'/>"}
    src = write(tmp_path / f"in{start}", scene(), metadata, [cv2.IMWRITE_WEBP_QUALITY, 101])
    old_pixels, old = read_picture(src)
    process_video(src, tmp_path / f"out{end}")
    pixels, new = read_picture(tmp_path / f"out{end}")
    assert pixels.shape == (40, 60, 3)
    assert set(old) == set(new) >= {EXIF, ICC}
    for kind in old:
        assert bytes(new[kind]) == bytes(old[kind])
    assert new[ICC] == PROFILE
    lossless = end in (".png", ".webp")
    assert np.abs(pixels.astype(int) - old_pixels).max() <= (0 if lossless else 12)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_face_is_upright_under_every_orientation(tmp_path, orientation):
    """Exif 2.32 (table 6) defines where row 0 and column 0 are; OpenCV turns the picture back."""
    from makeup_video.pipeline.faces.find import find_faces_in_frame

    upright = portrait()[..., ::-1]
    stored = {
        1: upright, 2: upright[:, ::-1], 3: upright[::-1, ::-1], 4: upright[::-1],
        5: upright.transpose(1, 0, 2), 6: np.rot90(upright, 1),
        7: upright[::-1, ::-1].transpose(1, 0, 2), 8: np.rot90(upright, -1),
    }[orientation]  # fmt: skip
    src = write(tmp_path / "in.png", np.ascontiguousarray(stored), {EXIF: exif(orientation)})
    np.testing.assert_array_equal(cv2.imread(str(src)), upright)
    pixels, metadata = read_picture(src)
    frame = to_frame(pixels, exif_orientation(metadata[EXIF]))
    assert frame.is_mirrored == (orientation in (2, 4, 5, 7))
    (face,) = find_faces_in_frame(frame)[0].faces
    xy = face.points_px[:, :2].astype(int)
    turned = np.zeros(pixels.shape[:2], np.uint8)
    chin, brow = xy[152], xy[10]
    turned[chin[1], chin[0]], turned[brow[1], brow[0]] = 2, 1
    turned = np.rot90(turned, frame.rotation_degrees // 90)
    row = {mark: int(np.argwhere(turned == mark)[0, 0]) for mark in (1, 2)}
    assert row[2] - row[1] > 150  # the chin is below the brow, by the height of the face


def test_metadata_that_a_format_refuses_is_reported(tmp_path):
    src = write(tmp_path / "in.webp", scene(), {ICC: b"no profile" * 40})
    report = process_video(src, tmp_path / "out.png")
    assert report.dropped == ["ICC profile: not accepted in .png"]


@pytest.mark.parametrize("space", ["CMYK", "GRAY"])
@pytest.mark.parametrize("end", [".jpg", ".png", ".webp"])
def test_a_profile_of_other_colours_is_left_out(tmp_path, space, end):
    profile = PROFILE[:16] + space.encode() + PROFILE[20:]
    src = write(tmp_path / "in.jpg", scene(), {ICC: profile})
    report = process_video(src, tmp_path / f"out{end}")
    assert report.dropped == [f"ICC profile: it is of {space}, and the picture is written as RGB"]
    assert ICC not in read_picture(tmp_path / f"out{end}")[1]


def test_a_grey_picture_that_stays_grey_keeps_its_profile(tmp_path):
    for space in ("GRAY", "RGB"):
        profile = PROFILE[:16] + space.ljust(4).encode() + PROFILE[20:]
        src = write(tmp_path / f"{space}.jpg", scene((40, 60, 1)), {ICC: profile})
        report = process_video(src, tmp_path / f"out-{space}.jpg", None, Settings(strict=True))
        assert report.dropped == []
        assert read_picture(tmp_path / f"out-{space}.jpg")[1][ICC] == profile


@pytest.mark.parametrize("end", [".jpg", ".png", ".webp"])
def test_grey_that_becomes_rgb_has_a_line(tmp_path, end):
    src = write(tmp_path / "in.png", cv2.cvtColor(portrait(), cv2.COLOR_RGB2GRAY))
    look, strict = Look(lips=product("#B4002E", "matte")), Settings(strict=True)
    report = process_video(src, tmp_path / f"out{end}", look)
    assert report.conversions == ["grey -> RGB"] and report.painted_frames == 1
    with pytest.raises(StrictError, match=r"grey -> RGB\. Leave strict out\.$"):
        process_video(src, tmp_path / f"strict{end}", look, strict)
    if end == ".webp":  # WebP holds no grey and no grey profile
        grey = PROFILE[:16] + b"GRAY" + PROFILE[20:]
        src = write(tmp_path / "bare.jpg", scene((40, 60, 1)), {ICC: grey})
        report = process_video(src, tmp_path / "bare.webp")
        assert report.conversions == ["grey -> RGB"] and len(report.dropped) == 1
        with pytest.raises(StrictError, match=r"grey -> RGB\. Use \.png, or leave strict out\.$"):
            process_video(src, tmp_path / "strict.webp", None, strict)
    else:
        assert process_video(src, tmp_path / f"bare{end}", None, strict).conversions == []


def test_transparency_into_jpeg_is_reported_and_laid_on_white(tmp_path):
    pixels = np.zeros((16, 16, 4), np.uint8)
    report = process_video(write(tmp_path / "in.png", pixels), tmp_path / "out.jpg")
    assert len(report.dropped) == 1 and "white" in report.dropped[0]
    assert read_picture(tmp_path / "out.jpg")[0].min() > 250


@pytest.mark.parametrize("end", [".jpg", ".webp"])
def test_16_bits_into_an_8_bit_format_are_reported(tmp_path, end):
    src = write(tmp_path / "in.png", scene(dtype=np.uint16))
    report = process_video(src, tmp_path / f"out{end}")
    assert report.conversions == [f"16 bits -> 8 bits ({'JPEG' if end == '.jpg' else 'WebP'})"]


@pytest.mark.parametrize("bits", [10, 12])
def test_a_deep_photo_is_reported_with_its_own_depth(tmp_path, bits):
    src = tmp_path / "in.heic"
    src.write_bytes(heic(scene((64, 64, 3)), bit_depth=bits))
    assert process_video(src, tmp_path / "out.png").conversions == []
    report = process_video(src, tmp_path / "out.jpg")
    assert report.conversions == [f"{bits} bits -> 8 bits (JPEG)"]


def test_what_is_laid_on_white_is_rounded_to_the_nearest_code(tmp_path):
    """Code 10 with an alpha of 100 of 255 on white is 158.9."""
    grey = np.full((16, 16, 4), (10, 10, 10, 100), np.uint8)
    process_video(write(tmp_path / "in.png", grey), tmp_path / "out.jpg")
    assert (read_picture(tmp_path / "out.jpg")[0] == 159).all()


@pytest.mark.parametrize("kind", ["16 bits", "transparent"])
def test_strict_refuses_what_a_picture_would_lose(tmp_path, kind):
    pixels = scene(dtype=np.uint16) if kind == "16 bits" else scene((40, 60, 4))
    src = write(tmp_path / "in.png", pixels)
    with pytest.raises(StrictError, match=r"cannot keep .*\. Use \.png, or leave strict out\.$"):
        process_video(src, tmp_path / "out.jpg", None, Settings(strict=True))
    assert [path.name for path in tmp_path.iterdir()] == ["in.png"]
    process_video(src, tmp_path / "out.png", None, Settings(strict=True))


@pytest.mark.parametrize(
    ("lost", "end"),
    [("behind the picture", ".jpg"), ("CMYK", ".jpg"), ("CMYK", ".webp"), ("comment", ".webp")],
)
def test_png_is_not_advised_where_it_loses_the_same(tmp_path, lost, end):
    src = tmp_path / "in.jpg"
    stored = Image.fromarray(scene()).convert("CMYK" if lost == "CMYK" else "RGB")
    stored.save(src, comment=b"by Jane" if lost == "comment" else None)
    if lost == "behind the picture":
        src.write_bytes(src.read_bytes() * 2)
    with pytest.raises(StrictError, match=rf"{lost}.*\. Leave strict out\.$"):
        process_video(src, tmp_path / f"out{end}", None, Settings(strict=True))


def test_an_animated_picture_is_a_video(tmp_path):
    with av.open(str(tmp_path / "in.png"), "w", format="apng") as out:
        stream = out.add_stream("apng", rate=10)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "rgb24"
        for index in range(5):
            out.mux(stream.encode(picture(index, 64, 48, "rgb24")))
        out.mux(stream.encode(None))
    assert process_video(tmp_path / "in.png", tmp_path / "out.mp4").frames_out == 5
    jpegs = b"".join(write(tmp_path / "one.jpg", scene(seed=i)).read_bytes() for i in range(5))
    (tmp_path / "in.mjpeg").write_bytes(jpegs)
    assert process_video(tmp_path / "in.mjpeg", tmp_path / "mjpeg.mp4").frames_out == 5
    with pytest.raises(UsageError, match=r"in\.png is an animated PNG: output must end in \.mp4"):
        process_video(tmp_path / "in.png", tmp_path / "out.png")
    png = (tmp_path / "in.png").read_bytes()
    text = struct.pack(">I", 9006) + b"tEXt" + b"Title\0" + b"a" * 9000
    text += struct.pack(">I", zlib.crc32(text[4:]))  # before the mark of an animation
    (tmp_path / "late.png").write_bytes(png[:33] + text + png[33:])
    assert process_video(tmp_path / "late.png", tmp_path / "late.mp4").frames_out == 5
    flags = bytes([0x20 | 2, 0, 0, 0])  # an ICC profile and an animation
    webp = b"RIFF\0\0\0\0WEBPVP8X\x0a\0\0\0" + flags + bytes(6) + b"ICCP" + bytes(900)
    (tmp_path / "in.webp").write_bytes(webp + b"ANIM" + bytes(40))
    with pytest.raises(DecodeError, match="animated WebP"):
        process_video(tmp_path / "in.webp", tmp_path / "out.png")


@pytest.mark.parametrize("start", [".jpg", ".png", ".webp"])
def test_a_damaged_picture_is_refused_in_one_line(tmp_path, start, capfd):
    src = write(tmp_path / f"in{start}", scene((200, 200, 3)))
    src.write_bytes(src.read_bytes()[:60])
    with pytest.raises(DecodeError, match="in") as caught:
        process_video(src, tmp_path / "out.png")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out.png").exists()
    assert capfd.readouterr().err == ""


def test_a_picture_is_recognised_by_its_bytes_not_its_name(tmp_path):
    write(tmp_path / "in.png", scene()).rename(tmp_path / "photo")
    process_video(tmp_path / "photo", tmp_path / "out.png")
    assert (tmp_path / "out.png").exists()


@pytest.mark.parametrize("kind", ["a TIFF", "a BMP", "an AVIF"])
def test_pictures_of_other_kinds_are_named(tmp_path, kind):
    src = tmp_path / "photo"
    Image.fromarray(scene()).save(src, format=kind.split()[1])
    with pytest.raises(DecodeError, match=f"is {kind} picture, .* save it as PNG first"):
        process_video(src, tmp_path / "out.png")


@pytest.mark.parametrize("end", [".png", ".webp"])
def test_colours_of_transparent_pixels_are_kept(tmp_path, end):
    pixels = scene((40, 60, 4))
    pixels[:20, :, 3] = 0
    process_video(write(tmp_path / "in.png", pixels), tmp_path / f"out{end}")
    np.testing.assert_array_equal(read_picture(tmp_path / f"out{end}")[0], pixels)


@pytest.mark.parametrize("name", ["out.mp4", "out", "out.gif", ".jpg"])
def test_a_picture_cannot_become_a_video(tmp_path, name):
    with pytest.raises(UsageError, match=r"must end in \.jpg"):
        process_video(write(tmp_path / "in.png", scene()), tmp_path / name)


def test_video_options_do_not_go_with_a_picture(tmp_path):
    src = write(tmp_path / "in.png", scene())
    for settings, flags in (
        (Settings(crf=20), "crf"),
        (
            Settings(start_seconds=Fraction(1), end_seconds=Fraction(2)),
            "start_seconds, end_seconds",
        ),
    ):
        with pytest.raises(UsageError, match=f"is a picture: leave out {flags} "):
            process_video(src, tmp_path / "out.png", None, settings)


def test_an_existing_picture_is_not_overwritten(tmp_path):
    src = write(tmp_path / "in.png", scene())
    (tmp_path / "out.png").write_text("precious")
    with pytest.raises(UsageError, match="add overwrite=True"):
        process_video(src, tmp_path / "out.png")
    with pytest.raises(OutputError, match="does not exist"):
        process_video(src, tmp_path / "no" / "out.png")


def test_a_decompression_bomb_is_refused(tmp_path):
    """A PNG header that declares 100000 x 100000 pixels."""
    head = b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + b"IHDR"
    body = struct.pack(">IIBBBBB", 100000, 100000, 8, 2, 0, 0, 0)
    (tmp_path / "in.png").write_bytes(head + body + bytes(200))
    with pytest.raises(DecodeError, match=r"in\.png"):
        process_video(tmp_path / "in.png", tmp_path / "out.png")


def as_p3(srgb8):
    """The same colours in Display P3: (H, W, 3) uint8 R'G'B'."""
    return (
        (to_encoded(to_linear(srgb8 / 255, SRGB) @ from_srgb_primaries(12).T, SRGB) * 255)
        .round()
        .astype(np.uint8)
    )


def test_lipstick_has_the_same_colour_in_display_p3(tmp_path):
    look = Look(lips=product("#B4002E", "matte"))
    for name, rgb8, icc in (
        ("srgb", portrait(), None),
        ("p3", as_p3(portrait()), profile(DISPLAY_P3, SRGB_CURVE)),
    ):
        Image.fromarray(rgb8).save(tmp_path / f"{name}.png", icc_profile=icc)
        process_video(tmp_path / f"{name}.png", tmp_path / f"{name}-out.png", look)
    srgb, wide = (
        np.array(Image.open(tmp_path / f"{name}-out.png").convert("RGB")) for name in ("srgb", "p3")
    )
    painted = np.abs(srgb.astype(int) - portrait()).max(2) > 20
    assert painted.sum() > 300
    wanted = as_p3(srgb)[painted].astype(int)
    assert np.abs(wide[painted] - wanted).mean() < 3
    assert np.abs(srgb[painted] - wanted).mean() > 6  # what it would be without the profile
