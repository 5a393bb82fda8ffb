"""Picture files read as they are stored, with their metadata."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import process_video
from makeup_video.pipeline.frames.orientation import ORIENTATIONS
from makeup_video.pipeline.frames.rgb import merge, to_frame
from makeup_video.pipeline.images.exif import orientation as exif_orientation
from picture_files import EXIF, XMP, exif, read_picture, scene, write
from PIL import Image


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize(
    ("orientation", "degrees"),
    [(1, 0), (2, 0), (3, 180), (4, 180), (5, 270), (6, 270), (7, 90), (8, 90), (99, 0)],
)
def test_exif_orientation_becomes_the_frames_rotation_degrees(
    tmp_path, order, orientation, degrees
):
    src = write(tmp_path / "in.jpg", scene(), {EXIF: exif(orientation, order)})
    assert exif_orientation(read_picture(src)[1][EXIF]).turn_degrees == degrees


def test_orientation_6_is_upright_after_270_degrees_left():
    """OpenCV turns the same picture 90 degrees clockwise when it honours Exif."""
    upright = scene()
    stored = np.rot90(upright, 1)  # counter-clockwise, as the camera was held
    ok, data = cv2.imencodeWithMetadata(
        ".png", stored, [int(cv2.IMAGE_METADATA_EXIF)], [np.frombuffer(exif(6), np.uint8)]
    )
    assert ok
    turned = cv2.imdecode(data, cv2.IMREAD_COLOR)
    np.testing.assert_array_equal(turned, np.rot90(stored, 270 // 90))


@given(data=st.binary(max_size=80))
def test_any_exif_bytes_give_a_valid_rotation(data):
    assert exif_orientation(b"II*\0" + data) in ORIENTATIONS.values()


@given(seed=st.integers(0, 99), shape=st.sampled_from([(9, 7, 3), (8, 8, 4), (5, 6, 1)]),
       dtype=st.sampled_from([np.uint8, np.uint16]))  # fmt: skip
@settings(deadline=None, max_examples=40)
def test_only_painted_pixels_change(seed, shape, dtype):
    pixels = scene(shape, dtype, seed)
    frame = to_frame(pixels)
    assert frame.chroma == (1, 1) and frame.tags.range == 2 and frame.bit_depth == 8
    before = [plane.copy() for plane in frame.planes]
    painted = np.zeros(shape[:2], bool)
    painted[[2, 4], [3, 5]] = True  # the pixels between the two stay
    luma = frame.writable_planes()[0]
    luma[painted] = 255 - (luma[painted] > 127) * 255
    out = merge(pixels, frame, before)
    changed = before[0] != frame.planes[0]
    scale = 1 if dtype == np.uint8 else 257
    original = np.repeat(pixels, 3, axis=2) if shape[2] == 1 else pixels
    np.testing.assert_array_equal(out[~changed], original[~changed])
    assert (np.abs(out[changed][:, :3].astype(int) - original[changed][:, :3]) > 8 * scale).any()
    if shape[2] == 4:
        np.testing.assert_array_equal(out[..., 3], pixels[..., 3])


@pytest.mark.parametrize("shape", [(9, 7, 3), (5, 6, 1)])
def test_pixels_that_nobody_painted_are_the_same_array(shape):
    pixels = scene(shape)
    frame = to_frame(pixels)
    assert merge(pixels, frame, [plane.copy() for plane in frame.planes]) is pixels


def test_the_frame_shows_the_colours_of_the_file():
    pixels = scene((32, 32, 3))
    frame = to_frame(pixels)
    luma, cb, cr = (plane.astype(float) for plane in frame.planes)
    blue, green, red = (pixels[..., i].astype(float) for i in range(3))
    # BT.709, full range (Rec. ITU-R BT.709-6, item 3.2)
    want = 0.2126 * red + 0.7152 * green + 0.0722 * blue
    assert np.abs(luma - want).max() < 1.5
    assert np.abs(cb - (128 + (blue - want) / 1.8556)).max() < 1.5
    assert np.abs(cr - (128 + (red - want) / 1.5748)).max() < 1.5


@pytest.mark.parametrize("start", [".png", ".webp"])
@pytest.mark.parametrize(
    ("kind", "name", "block", "most"),
    [  # a segment of 65533 bytes, less the mark of XMP or of EXIF
        (XMP, "XMP", b"<" + bytes(70000).replace(b"\0", b"x") + b">", 65504),
        (EXIF, "EXIF", exif(1) + bytes(70000), 65527),
    ],
)
def test_a_block_too_long_for_a_jpeg_alone_is_lost(tmp_path, start, kind, name, block, most):
    for size, dropped in ((most, []), (most + 1, [f"{name}: not accepted in .jpg"])):
        data = block[: size - 1] + block[-1:]
        src = write(tmp_path / f"in{start}", scene(), {kind: data})
        (tmp_path / "out.jpg").unlink(missing_ok=True)
        assert process_video(src, tmp_path / "out.jpg").dropped == dropped
        kept = read_picture(tmp_path / "out.jpg")[1].get(kind, b"")
        assert (len(kept) == size) == (not dropped)


@pytest.mark.parametrize("turned", range(1, 9))
def test_of_exif_too_long_for_a_jpeg_the_orientation_stays(tmp_path, turned):
    src = write(tmp_path / "in.png", scene(), {EXIF: exif(turned) + bytes(70000)})
    assert process_video(src, tmp_path / "out.jpg").dropped == ["EXIF: not accepted in .jpg"]
    with Image.open(tmp_path / "out.jpg") as picture:
        assert picture.getexif().get(0x0112) == turned
