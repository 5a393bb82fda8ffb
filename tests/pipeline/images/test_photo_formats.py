"""Photos with tags of the wrong type, and files that change while they are read."""

import io
import os
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from makeup_video.pipeline import InputError, PhotoError
from makeup_video.pipeline.images import photo_file
from makeup_video.pipeline.images.photo_file import read_photo
from media import make_clip
from PIL import ExifTags, Image, PngImagePlugin, TiffImagePlugin
from PIL.TiffImagePlugin import IFDRational

PIXELS = np.random.default_rng(0).integers(0, 255, (20, 30, 3)).astype(np.uint8)
# Types of TIFF 6.0 (section 2): 2 text, 3 and 4 whole numbers, 5 a fraction, 7 bytes, 12 a double.
WRONG = [(2, "text"), (3, 99), (5, IFDRational(1, 0)), (7, b"\6\0"), (12, 99.5), (12, float("inf")),
         (12, float("nan"))]  # fmt: skip


def tiff(tag, kind, value):
    entries = TiffImagePlugin.ImageFileDirectory_v2()
    entries[tag] = value
    entries.tagtype[tag] = kind
    file = io.BytesIO()
    Image.fromarray(PIXELS).save(file, "TIFF", tiffinfo=entries)
    return file.getvalue()


@pytest.mark.parametrize(("kind", "value"), [*WRONG, (7, b"no profile"), (4, 2**31)])
@pytest.mark.parametrize("tag", [ExifTags.Base.InterColorProfile, ExifTags.Base.Orientation])
def test_a_tag_of_the_wrong_type_is_ignored(tag, kind, value):
    np.testing.assert_array_equal(read_photo(tiff(tag, kind, value)), PIXELS)


@pytest.mark.parametrize("with_exif", [False, True])
@pytest.mark.parametrize("end", ["jpg", "png", "webp", "avif", "tif"])
def test_xmp_does_not_turn_a_photo(tmp_path, end, with_exif):
    """Viewers go by EXIF alone, and so do painting and `inspect`."""
    rgb8 = np.full((40, 64, 3), (180, 90, 60), np.uint8)
    xmp = b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><a tiff:Orientation="6"/></x:xmpmeta>'
    options = {"xmp": xmp}
    if end == "png":
        options = {"pnginfo": PngImagePlugin.PngInfo()}
        options["pnginfo"].add_itxt("XML:com.adobe.xmp", xmp.decode())
    if end == "tif":
        options = {"tiffinfo": {700: xmp}}
    if with_exif:
        options["exif"] = Image.Exif()
        options["exif"][ExifTags.Base.Make] = "a camera"
    Image.fromarray(rgb8).save(tmp_path / f"in.{end}", **options)
    with Image.open(tmp_path / f"in.{end}") as picture:
        assert picture.getexif().get(0x0112) == 6  # Pillow does
    assert read_photo(tmp_path / f"in.{end}").shape == rgb8.shape


def test_an_orientation_may_be_a_fraction():
    data = tiff(ExifTags.Base.Orientation, 5, IFDRational(6, 1))
    np.testing.assert_array_equal(read_photo(data), np.rot90(PIXELS, -1))


def saved(path, **options):
    Image.fromarray(PIXELS).save(path, **options)
    return path


def when_opened(monkeypatch, action):
    """Call `action` as soon as Pillow has recognised the format of the file."""

    def open_then_act(*args, **options):
        picture = original(*args, **options)
        action()
        return picture

    original = Image.open
    monkeypatch.setattr(Image, "open", open_then_act)


@pytest.mark.parametrize("change", ["removed", "replaced"])
@pytest.mark.parametrize(
    ("name", "options"), [("in.jpg", {"progressive": True}), ("in.png", {}), ("in.tif", {})]
)
def test_a_photo_may_disappear_while_it_is_read(tmp_path, monkeypatch, name, options, change):
    path = saved(tmp_path / name, **options)
    want = read_photo(path)
    (tmp_path / "other").write_bytes(b"x" * 9)
    actions = {"removed": path.unlink, "replaced": lambda: os.replace(tmp_path / "other", path)}
    when_opened(monkeypatch, actions[change])
    np.testing.assert_array_equal(read_photo(path), want)


def test_a_file_may_disappear_while_its_kind_is_determined(tmp_path, monkeypatch):
    path = make_clip(tmp_path / "in.mp4", frames=2)

    def remove_and_fail(*_args, **_options):
        path.unlink()
        raise photo_file.UnidentifiedImageError

    monkeypatch.setattr(Image, "open", remove_and_fail)
    with pytest.raises(PhotoError, match=r"in\.mp4 is no photo"):
        read_photo(path)


def test_a_photo_that_is_gone_before_it_is_opened_is_one_line(tmp_path, monkeypatch):
    path = saved(tmp_path / "in.png")

    def find_then_remove(*_args):
        path.unlink()
        return path

    monkeypatch.setattr("makeup_video.pipeline.images.photo_file.local_file", find_then_remove)
    with pytest.raises(InputError, match=r"in\.png cannot be read: No such file.*; give a file on"):
        read_photo(path)


def test_a_file_larger_than_any_photo_is_not_read(tmp_path):
    path = saved(tmp_path / "in.jpg", progressive=True)
    with path.open("r+b") as file:
        file.truncate(3_000_000_000)  # sparse: takes no disk space
    with pytest.raises(InputError, match=r"in\.jpg cannot be read: it has more than 1000 MB; give"):
        read_photo(path)


def test_every_kind_of_photo_leaves_no_file_open(tmp_path):
    before = open_files()
    for name in ("in.jpg", "in.png", "in.tif", "in.webp", "in.bmp", "in.avif"):
        read_photo(saved(tmp_path / name))
    assert open_files() == before


def open_files():
    return sorted(os.readlink(link) for link in Path("/proc/self/fd").iterdir() if link.exists())


def test_what_pillow_logs_of_a_damaged_file_is_not_printed(tmp_path):
    """A TIFF whose picture claims 31960 samples a pixel, which Pillow logs as an error."""
    path = tmp_path / "in.tiff"
    Image.new("RGB", (16, 16)).save(path)
    data = bytearray(path.read_bytes())
    offset = data.index(struct.pack("<HH", 277, 3))  # SamplesPerPixel
    struct.pack_into("<H", data, offset + 8, 31960)
    path.write_bytes(data)
    program = (
        "import sys; from makeup_video.pipeline.images.photo_file import read_photo\n"
        "read_photo(sys.argv[1])"
    )
    # a process of its own, because pytest captures the log in this one
    command = [sys.executable, "-c", program, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "PhotoError" in done.stderr and "More samples per pixel" not in done.stderr
