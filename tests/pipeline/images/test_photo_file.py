"""Photos become upright sRGB arrays; any other file is refused in one line with advice."""

import io
import struct
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from icc_profiles import ADOBE_RGB, DISPLAY_P3, SRGB_COLORANTS, SRGB_CURVE, profile
from makeup_video.kernels.colour import SRGB, to_encoded, to_linear, to_xyz
from makeup_video.pipeline import InputError, MakeupVideoError, PhotoError
from makeup_video.pipeline.images import photo_file
from makeup_video.pipeline.images.photo_file import LARGE_PX, read_photo
from media import make_clip
from people import portrait
from PIL import GifImagePlugin, Image, TiffImagePlugin


def colours(shape=(24, 32, 3), seed=0):
    """Return smooth RGB, uint8, which JPEG keeps nearly unchanged."""
    small = np.random.default_rng(seed).integers(60, 190, (3, 4, 3)).astype(np.uint8)
    return cv2.resize(small, shape[1::-1], interpolation=cv2.INTER_CUBIC)


def save(path, rgb8, **options):
    Image.fromarray(rgb8).save(path, **options)
    return path


def exif(orientation):
    tags = Image.Exif()
    tags[0x0112] = orientation
    return tags


@pytest.mark.parametrize("end", [".png", ".bmp", ".tif", ".webp"])
def test_a_lossless_picture_is_the_array(tmp_path, end):
    rgb8 = colours()
    path = save(tmp_path / f"in{end}", rgb8, **({"lossless": True} if end == ".webp" else {}))
    np.testing.assert_array_equal(read_photo(path), rgb8)


@pytest.mark.parametrize("end", [".jpg", ".webp", ".avif"])
def test_a_lossy_picture_is_close_to_the_array(tmp_path, end):
    path = save(tmp_path / f"in{end}", colours(), quality=95)
    assert np.abs(read_photo(path).astype(int) - colours()).mean() < 4


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("end", [".png", ".jpg", ".webp", ".tif"])
def test_exif_orientation_is_undone(tmp_path, end, orientation):
    upright = colours()
    stored = {
        1: upright, 2: upright[:, ::-1], 3: upright[::-1, ::-1], 4: upright[::-1],
        5: upright.transpose(1, 0, 2), 6: np.rot90(upright, 1),
        7: upright[::-1, ::-1].transpose(1, 0, 2), 8: np.rot90(upright, -1),
    }[orientation]  # fmt: skip
    options = {".jpg": {"quality": 95, "subsampling": 0}, ".webp": {"lossless": True}}.get(end, {})
    path = save(
        tmp_path / f"in{end}", np.ascontiguousarray(stored), exif=exif(orientation), **options
    )
    difference = np.abs(read_photo(path).astype(int) - upright)
    assert difference.mean() < (4 if end == ".jpg" else 0.01)


def test_orientation_behind_a_pngs_pixels_is_undone(tmp_path):
    sideways = np.ascontiguousarray(np.rot90(colours(), 1))
    data = bytes_of(sideways, "PNG")
    tags = exif(6).tobytes().removeprefix(b"Exif\0\0")
    chunk = (
        struct.pack(">I", len(tags))
        + b"eXIf"
        + tags
        + struct.pack(">I", zlib.crc32(b"eXIf" + tags))
    )
    (tmp_path / "in.png").write_bytes(data[:-12] + chunk + data[-12:])
    np.testing.assert_array_equal(read_photo(tmp_path / "in.png"), colours())


@pytest.mark.parametrize(
    ("colorants", "curve", "to_linear_light", "to_srgb"),
    [
        (
            DISPLAY_P3, SRGB_CURVE, lambda codes: to_linear(codes, SRGB),
            np.linalg.inv(to_xyz(1)) @ to_xyz(12),
        ),
        (
            ADOBE_RGB, (2.19921875,), lambda codes: codes**2.19921875,
            # Adobe RGB (1998), 4.3.5.3, then IEC 61966-2-1
            np.linalg.inv(to_xyz(1))
            @ [[0.57667, 0.18556, 0.18823],
               [0.29734, 0.62736, 0.07529],
               [0.02703, 0.07069, 0.99134]],
        ),
    ],
    ids=["Display P3", "Adobe RGB"],
)  # fmt: skip
def test_an_icc_profile_is_converted_to_srgb(tmp_path, colorants, curve, to_linear_light, to_srgb):
    rgb8 = colours()
    path = save(tmp_path / "in.png", rgb8, icc_profile=profile(colorants, curve))
    wanted = 255 * to_encoded(to_linear_light(rgb8 / 255) @ to_srgb.T, SRGB).clip(0, 1)
    assert np.abs(wanted - rgb8).max() > 5
    assert np.abs(read_photo(path) - wanted).max() < 2.5  # littleCMS rounds in between


def test_a_linear_profile_named_srgb_is_converted(tmp_path):
    linear = profile(SRGB_COLORANTS, (1.0,), "sRGB-elle-V2-g10")
    path = save(tmp_path / "in.png", colours(), icc_profile=linear)
    wanted = 255 * to_encoded(colours() / 255, SRGB)
    assert np.abs(read_photo(path) - wanted).max() < 2.5  # littleCMS rounds in between


@pytest.mark.parametrize("name", ["sRGB", "sRGB IEC61966-2.1", "of somebody"])
def test_a_profile_of_srgb_changes_next_to_nothing(tmp_path, name):
    data = profile(SRGB_COLORANTS, SRGB_CURVE, name)
    path = save(tmp_path / "in.png", colours(), icc_profile=data)
    assert np.abs(read_photo(path).astype(int) - colours()).max() <= 1


@pytest.mark.parametrize(
    "data", [b"no profile", b"", profile(DISPLAY_P3, SRGB_CURVE, space=b"CMYK")[:200]]
)
def test_broken_profiles_change_nothing(tmp_path, data):
    path = save(tmp_path / "in.png", colours(), icc_profile=data)
    np.testing.assert_array_equal(read_photo(path), colours())


def test_cmyk_as_photoshop_writes_it_has_its_colours(tmp_path):
    Image.fromarray(colours()).convert("CMYK").save(tmp_path / "in.jpg", quality=95)
    assert np.abs(read_photo(tmp_path / "in.jpg").astype(int) - colours()).mean() < 6


def test_16_bits_and_an_opaque_alpha_change_nothing(tmp_path):
    bgr = colours()[..., ::-1]
    cv2.imwrite(str(tmp_path / "deep.png"), bgr.astype(np.uint16) * 257)
    opaque = np.dstack([bgr, np.full(bgr.shape[:2], 255, np.uint8)])
    cv2.imwrite(str(tmp_path / "opaque.png"), opaque)
    for name in ("deep.png", "opaque.png"):
        np.testing.assert_array_equal(read_photo(tmp_path / name), colours())


def test_what_is_transparent_is_middle_grey(tmp_path):
    alpha = np.zeros(colours().shape[:2], np.uint8)
    alpha[:, 16:] = 255
    save(tmp_path / "in.png", np.dstack([colours(), alpha]))
    got = read_photo(tmp_path / "in.png")
    assert (got[:, :16] == 128).all()
    np.testing.assert_array_equal(got[:, 16:], colours()[:, 16:])


def test_a_palette_is_a_picture_too(tmp_path):
    Image.fromarray(colours()).quantize(64).save(tmp_path / "in.gif")
    assert np.abs(read_photo(tmp_path / "in.gif").astype(int) - colours()).mean() < 8


def test_the_first_picture_of_a_phones_file_is_the_photo(tmp_path):
    first, second = Image.fromarray(colours()), Image.fromarray(colours(seed=1))
    first.save(tmp_path / "in.jpg", "MPO", save_all=True, append_images=[second], quality=95)
    assert np.abs(read_photo(tmp_path / "in.jpg").astype(int) - colours()).mean() < 4


def test_a_very_large_photo_is_averaged_down(tmp_path):
    wide = np.full((40, LARGE_PX + 2, 3), (200, 90, 40), np.uint8)
    got = read_photo(save(tmp_path / "in.png", wide))
    assert got.shape == (20, LARGE_PX // 2 + 1, 3) and (got == (200, 90, 40)).all()


def png_of(width, height):
    """Return a PNG that declares a size and holds no pixels."""
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(b"")), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in chunks
    )


def bytes_of(rgb8, kind, **options):
    file = io.BytesIO()
    Image.fromarray(rgb8).save(file, kind, **options)
    return file.getvalue()


def animated(kind):
    more = [Image.fromarray(colours(seed=1))]
    return bytes_of(colours(), kind, save_all=True, append_images=more)


def many_passes():
    """Return a small JPEG that makes a decoder decode the whole picture 700 times."""
    data = bytes_of(np.zeros((2000, 2000, 3), np.uint8), "JPEG", progressive=True)
    last = data.rindex(b"\xff\xda")
    return data[:-2] + data[last:-2] * 700 + data[-2:]


BAD = {
    "grey.jpg": (lambda: bytes_of(colours()[..., 0], "JPEG"), "is a grey picture"),
    "grey16.png": (
        lambda: cv2.imencode(".png", colours()[..., 0].astype(np.uint16) * 257)[1].tobytes(),
        "is a grey picture"),
    "cut.jpg": (lambda: bytes_of(portrait(), "JPEG")[:9000], "damaged or cut short"),
    "cut.png": (lambda: bytes_of(portrait(), "PNG")[:9000], "damaged or cut short"),
    "empty.png": (lambda: png_of(30, 20), "damaged or cut short"),
    "cut.avif": (lambda: bytes_of(portrait(), "AVIF")[:9000], "damaged or cut short"),
    "cut.webp": (lambda: bytes_of(portrait(), "WEBP")[:20], "damaged or cut short"),
    "header.jpg": (lambda: bytes_of(portrait(), "JPEG")[:100], "damaged or cut short"),
    "float.tif": (lambda: cv2.imencode(".tif", colours().astype(np.float32))[1].tobytes(),
                  "a kind of TIFF that cannot be read here"),
    "large.png": (lambda: png_of(12000, 12000), "has 12000 x 12000 px, more than 120 million px"),
    "bomb.png": (lambda: png_of(60000, 60000), "bomb.png has more than 120 million px: make it"),
    "moving.gif": (lambda: animated("GIF"), "holds several pictures"),
    "moving.png": (lambda: animated("PNG"), "holds several pictures"),
    "moving.webp": (lambda: animated("WEBP"), "holds several pictures"),
    "pages.tif": (lambda: animated("TIFF"), "holds several pictures"),
    "passes.jpg": (many_passes, "is stored in far too many passes"),
    "phone.heic": (lambda: b"\0\0\0\x18ftypheic\0\0\0\0mif1heic" + bytes(80),
                   "damaged or cut short"),
    "burst.heics": (lambda: b"\0\0\0\x18ftyphevc\0\0\0\0msf1hevc" + bytes(80),
                    "holds several pictures"),
    "words.jpg": (lambda: b"no photo at all", "is no photo that can be read: give a JPEG"),
    "nothing.jpg": (lambda: b"", "is empty (0 bytes): give a photo file"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_file_that_is_no_photo_is_one_line_with_advice(tmp_path, name):
    make, words = BAD[name]
    (tmp_path / name).write_bytes(make())
    with pytest.raises(InputError) as caught:
        read_photo(tmp_path / name)
    message = str(caught.value)
    assert words in message and name in message and "\n" not in message
    assert caught.value.exit_code == 3


@pytest.mark.parametrize("kind", ["GIF", "TIFF"])
def test_the_pictures_in_a_file_are_not_counted(monkeypatch, kind):
    def count_pictures(self):
        raise AssertionError

    plugin = {"GIF": GifImagePlugin.GifImageFile, "TIFF": TiffImagePlugin.TiffImageFile}[kind]
    monkeypatch.setattr(plugin, "n_frames", property(count_pictures))
    with pytest.raises(PhotoError, match="several pictures"):
        read_photo(animated(kind), "moving")


@pytest.mark.parametrize("name", BAD)
def test_bytes_are_refused_like_files_under_their_name(name):
    make, words = BAD[name]
    with pytest.raises(InputError) as caught:
        read_photo(make(), name)
    message = str(caught.value)
    assert words in message and name in message and "\n" not in message


@pytest.mark.parametrize("end", [".png", ".jpg", ".webp", ".tif", ".bmp", ".avif", ".gif"])
def test_the_bytes_of_a_file_give_the_picture_of_the_file(tmp_path, end):
    path = save(tmp_path / f"in{end}", colours(), **({"exif": exif(6)} if end == ".jpg" else {}))
    np.testing.assert_array_equal(read_photo(path.read_bytes()), read_photo(path))


@pytest.mark.parametrize("name", ["in.mp4", "in.mkv", "in.avi", "in.flv", "in.mpg"])
def test_the_bytes_of_a_video_are_refused_with_advice(tmp_path, name):
    codec = {"in.flv": "h264", "in.mp4": "h264"}.get(name, "mpeg4")
    clip = make_clip(tmp_path / name, codec)
    with pytest.raises(PhotoError, match=rf"{name} is a video.*give a screenshot") as caught:
        read_photo(clip.read_bytes(), name)
    assert "ffmpeg" not in str(caught.value)  # the bytes come from a browser, not from a shell


def test_a_video_is_refused_with_how_to_take_a_frame(tmp_path):
    with pytest.raises(PhotoError, match=r"is a video.*ffmpeg -ss SECONDS -i in.mp4"):
        read_photo(make_clip(tmp_path / "in.mp4"))


@pytest.mark.parametrize("broken", [TypeError, RuntimeError, ValueError])
def test_a_bug_of_ours_is_not_reported_as_damage(tmp_path, monkeypatch, broken):
    def fails(picture):
        raise broken("ours")

    monkeypatch.setattr(photo_file, "_pixels", fails)
    with pytest.raises(broken, match="ours"):
        read_photo(save(tmp_path / "in.png", colours()))


def test_too_little_memory_is_named_as_the_reason(tmp_path, monkeypatch):
    def fails(picture):
        raise MemoryError

    monkeypatch.setattr(photo_file, "_pixels", fails)
    with pytest.raises(PhotoError, match="needs more memory than there is"):
        read_photo(save(tmp_path / "in.png", colours()))


def test_damage_inside_an_avif_is_one_line(tmp_path):
    data = bytearray(bytes_of(portrait(), "AVIF"))
    offset = data.index(b"mdat") + 4
    data[offset : offset + 200] = bytes(200)
    (tmp_path / "in.avif").write_bytes(data)
    with pytest.raises(PhotoError, match="damaged or cut short"):
        read_photo(tmp_path / "in.avif")


@settings(max_examples=60, deadline=None)
@given(
    kind=st.sampled_from(["JPEG", "PNG", "WEBP", "AVIF", "TIFF", "BMP", "GIF"]),
    flips=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(1, 255)), max_size=6),
    keep=st.floats(0.01, 1),
)
def test_any_damage_is_a_picture_or_one_line(tmp_path_factory, kind, flips, keep):
    data = bytearray(bytes_of(colours(), kind, exif=exif(6)))
    for place, flip in flips:
        data[int(place * len(data))] ^= flip
    path = tmp_path_factory.mktemp("damaged") / "in"
    path.write_bytes(data[: max(1, int(keep * len(data)))])
    try:
        got = read_photo(path)
    except MakeupVideoError as error:
        assert "\n" not in str(error)
    else:
        assert got.ndim == 3 and got.shape[2] == 3 and got.dtype == np.uint8
