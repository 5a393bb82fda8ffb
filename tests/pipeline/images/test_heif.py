"""HEIC photos as phones make them: turned, in tiles, deep, wide, with a gain map."""

import sys

import cv2
import heif_files
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.kernels import colour
from makeup_video.pipeline import DecodeError, InstallError, PhotoError
from makeup_video.pipeline.images.heif import is_heif, to_srgb
from makeup_video.pipeline.images.photo_file import read_photo
from makeup_video.pipeline.images.picture_file import decode_picture, is_picture, read_bytes
from makeup_video.pipeline.offline.picture import open_picture, process_picture
from makeup_video.pipeline.offline.settings import Settings
from picture_files import EXIF, ICC, exif
from PIL import ImageCms

# Mean error, in codes, that x265 at CRF 4 and 4:2:0 stays below on smooth colours.
LOSS = 2.0


def colours(height=96, width=128, seed=0):
    small = np.random.default_rng(seed).integers(60, 190, (3, 4, 3)).astype(np.uint8)
    return cv2.resize(small, (width, height), interpolation=cv2.INTER_CUBIC)


def away(got, want):
    assert got.shape == want.shape
    return np.abs(got.astype(float) - want).mean()


def painted_from(path):
    """(R'G'B' on the scale of 8 bits, the stored picture that painting begins from, metadata)."""
    stored, metadata = decode_picture(read_bytes(path), path)
    eight = stored if stored.dtype == np.uint8 else stored / 257
    return eight[..., 2::-1], stored, metadata


@pytest.mark.parametrize("degrees", [0, 90, 180, 270])
@pytest.mark.parametrize("tile_px", [None, 64])
@pytest.mark.parametrize("bit_depth", [8, 10])
def test_a_heic_photo_is_read_upright(tmp_path, degrees, tile_px, bit_depth):
    rgb8 = colours()
    data = heif_files.heic(
        rgb8, tile_px=tile_px, bit_depth=bit_depth, rotation_degrees=degrees, exif=exif(6)
    )
    want = np.rot90(rgb8, degrees // 90)
    assert away(read_photo(data), want) < LOSS
    path = tmp_path / "in.heic"
    path.write_bytes(data)
    assert is_picture(path)
    got, stored, metadata = painted_from(path)
    assert away(got, want) < LOSS
    assert stored.dtype == (np.uint8 if bit_depth == 8 else np.uint16)
    # the EXIF block is kept, but must not turn the picture a second time
    assert EXIF in metadata
    assert open_picture(path).orientation.turn_degrees == 0


@settings(deadline=None, max_examples=12)
@given(st.integers(65, 200), st.integers(65, 200))
def test_tiles_that_reach_over_the_border_are_cut(height, width):
    # x265 pads odd sizes, and 4:2:0 grids have even sizes
    rgb8 = colours(height // 2 * 2, width // 2 * 2)
    assert away(read_photo(heif_files.heic(rgb8, tile_px=64)), rgb8) < LOSS


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("degrees", [0, 90, 180, 270])
def test_a_mirrored_heic_photo_is_read_upright(tmp_path, degrees, axis):
    rgb8 = colours()
    path = tmp_path / "in.heic"
    path.write_bytes(heif_files.heic(rgb8, rotation_degrees=degrees, mirror=axis, exif=exif(5)))
    want = np.flip(np.rot90(rgb8, degrees // 90), axis)
    assert away(read_photo(path), want) < LOSS
    assert away(painted_from(path)[0], want) < LOSS


@pytest.mark.parametrize("bit_depth", [8, 10])
@pytest.mark.parametrize("tile_px", [None, 64])
def test_gain_map_and_thumbnail_are_no_part_of_the_photo(tmp_path, tile_px, bit_depth):
    rgb8 = colours()
    plain, full = tmp_path / "plain.heic", tmp_path / "full.heic"
    shared = {"tile_px": tile_px, "bit_depth": bit_depth, "rotation_degrees": 270}
    plain.write_bytes(heif_files.heic(rgb8, **shared))
    beside = {"gain_map": np.full((96, 64, 3), 255, np.uint8), "thumbnail": 255 - rgb8[:64, :64]}
    full.write_bytes(heif_files.heic(rgb8, **shared, **beside, exif=exif(6)))
    np.testing.assert_array_equal(read_photo(full), read_photo(plain))
    np.testing.assert_array_equal(painted_from(full)[1], painted_from(plain)[1])


@pytest.mark.parametrize(
    ("aux", "name"),
    [
        (heif_files.GAIN_MAP, "gain map of HDR"),
        ("", "gain map of HDR"),
        ("urn:mpeg:hevc:2015:auxid:2", "depth"),
        ("urn:com:apple:photo:2018:aux:portraiteffectsmatte", "masks of the camera"),
        ("urn:mpeg:hevc:2015:auxid:1", None),  # transparency, which is kept
    ],
)
def test_what_stands_beside_a_heic_photo_has_a_line(tmp_path, aux, name):
    path, out = tmp_path / "in.heic", tmp_path / "out.png"
    path.write_bytes(heif_files.heic(colours(), gain_map=colours(), aux=aux))
    report = process_picture(path, out, lambda frame: frame, Settings())
    assert report.dropped == ([f"{name}: the picture is written alone"] if name else [])


def test_further_pictures_of_a_heic_photo_have_a_line(tmp_path):
    path, out = tmp_path / "in.heic", tmp_path / "out.png"
    path.write_bytes(heif_files.heic(colours(), further=colours(seed=1)))
    report = process_picture(path, out, lambda frame: frame, Settings())
    assert report.dropped == ["further pictures: the picture is written alone"]


@pytest.mark.parametrize(
    ("code_points", "line"),
    [
        ((9, 16, 9), "HDR (PQ) -> sRGB"),
        ((9, 18, 9), "HDR (HLG) -> sRGB"),
        ((12, 13, 1), "Display P3 -> sRGB"),
        ((9, 1, 9), "BT.2020 -> sRGB"),
        ((1, 13, 1), None),
    ],
)
def test_colours_that_become_srgb_have_a_line(tmp_path, code_points, line):
    path, out = tmp_path / "in.heic", tmp_path / "out.png"
    path.write_bytes(heif_files.heic(colours(), colr=heif_files.nclx(*code_points)))
    report = process_picture(path, out, lambda frame: frame, Settings())
    assert report.conversions == ([line] if line else [])


def test_a_profile_counts_for_a_look_and_is_kept_for_painting(tmp_path):
    rgb8 = colours()
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    path = tmp_path / "in.heic"
    path.write_bytes(heif_files.heic(rgb8, colr=heif_files.icc(profile)))
    got, _, metadata = painted_from(path)
    assert metadata[ICC] == profile
    assert away(got, rgb8) < LOSS
    assert away(read_photo(path), rgb8) < LOSS


@pytest.mark.parametrize("primaries", [9, 12])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_wide_colours_without_profile_become_srgb(primaries, dtype):
    most = np.iinfo(dtype).max
    srgb = np.random.default_rng(1).uniform(0.1, 0.9, (5, 7, 3))
    light = colour.to_linear(srgb, 13) @ colour.from_srgb_primaries(primaries).T
    wide = (colour.to_encoded(light, 13) * most + 0.5).astype(dtype)
    got = to_srgb(wide, {"color_primaries": primaries, "transfer_characteristics": 13})
    # half a code of 8 bits, enlarged by the matrix and the slopes of both curves
    assert np.abs(got / most - srgb).max() < 0.012


@pytest.mark.parametrize("transfer", [16, 18])
def test_hdr_is_rolled_off_and_mid_tones_stay(transfer):
    light = np.linspace(0.02, 4, 60)[:, None, None].repeat(3, -1)
    encoded = (colour.to_encoded(light, transfer) * 65535 + 0.5).astype(np.uint16)
    got = to_srgb(encoded, {"color_primaries": 9, "transfer_characteristics": transfer})
    shown = colour.to_linear(got / 65535, 13)
    low = light[:, 0, 0] <= 0.5
    assert np.abs(shown - light)[low].max() < 0.002
    assert np.all(np.diff(shown[:, 0, 0]) > 0) and shown.max() < 1


@pytest.mark.parametrize("nclx", [
    None, {}, {"color_primaries": 1, "transfer_characteristics": 1},
    {"color_primaries": 2, "transfer_characteristics": 2},
])  # fmt: skip
def test_srgb_stays_the_very_same_array(nclx):
    pixels = colours()
    assert to_srgb(pixels, nclx) is pixels


def test_transparency_is_no_colour():
    pixels = np.full((2, 2, 4), 100, np.uint8)
    pixels[..., 3] = 7
    got = to_srgb(pixels, {"color_primaries": 12, "transfer_characteristics": 13})
    assert np.all(got[..., 3] == 7) and np.all(got[..., :3] == 100)  # grey stays grey


@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.97])
def test_a_cut_heic_is_one_line(tmp_path, share):
    data = heif_files.heic(colours(), tile_px=64)
    path = tmp_path / "cut.heic"
    path.write_bytes(data[: int(len(data) * share)])
    with pytest.raises(PhotoError, match=r"cut\.heic is damaged or cut short"):
        read_photo(path)
    with pytest.raises(DecodeError, match=r"cut\.heic is damaged or cut short"):
        decode_picture(read_bytes(path), path)


def test_without_pi_heif_the_line_names_the_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pi_heif", None)  # as if it were not installed
    path = tmp_path / "in.heic"
    path.write_bytes(heif_files.heic(colours()))
    for read in (read_photo, read_bytes):
        with pytest.raises(InstallError, match="run pip install pi-heif, or save the photo"):
            read(path)


@pytest.mark.parametrize(("brands", "is_one"), [
    (b"heic\0\0\0\0mif1heic", True), (b"mif1\0\0\0\0mif1heicmiaf", True), (b"heix\0\0\0\0", True),
    (b"mif1\0\0\0\0mif1avif", False), (b"avif\0\0\0\0mif1", False), (b"isom\0\0\0\0isommp42", False),
    (b"qt  \0\0\0\0qt  ", False),
])  # fmt: skip
def test_a_heic_is_known_by_its_brands(brands, is_one):
    head = (8 + len(brands)).to_bytes(4, "big") + b"ftyp" + brands
    assert is_heif(head + b"heicmif1") is is_one  # what follows the first box does not count
