"""A visitor's photo is decoded in another process: the pixels are the same, limits hold, and a
crash is an error of one line."""

import io
import json
import os
import struct
import subprocess
import sys

import cv2
import heif_files
import numpy as np
import pytest
import simplejpeg
from makeup_video.pipeline import PhotoError
from makeup_video.pipeline.images.photo_file import read_photo
from makeup_video.web import photo_child, read_apart
from makeup_video.web.read_look import read_look
from people import SAMPLES
from PIL import Image
from shows import RED, Page, StandIn, serving

LOOK = (SAMPLES / "look.jpg").read_bytes()
on_linux = pytest.mark.skipif(sys.platform != "linux", reason="other systems keep other limits")


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "WEBP", "AVIF", "TIFF"])
def test_the_pixels_are_those_that_a_file_has(kind):
    file = io.BytesIO()
    Image.open(io.BytesIO(LOOK)).resize((333, 411)).save(file, kind)
    want = read_photo(file.getvalue())
    np.testing.assert_array_equal(read_apart.read_apart(file.getvalue(), "x"), want)


def test_a_phones_photo_is_decoded_within_the_limits():
    height, width = 5712, 4284  # of 24 megapixels
    tile = read_photo(LOOK)[300:812, 300:812]  # one for all, since the encoder takes its time
    rgb8 = np.tile(tile, (-(-height // 512), -(-width // 512), 1))[:height, :width]
    data = heif_files.heic(rgb8, tile_px=512)
    np.testing.assert_array_equal(read_apart.read_apart(data, "x"), read_photo(data))


@pytest.mark.parametrize("name", ["ä\u2028\n.jpg", '"', "x" * 500, "{}"])
def test_a_photo_is_refused_by_its_own_name(name):
    with pytest.raises(PhotoError) as caught:
        read_apart.read_apart(b"nothing", name)
    assert str(caught.value).startswith(f"{name} is no photo that can be read")


def test_other_users_do_not_see_the_name_of_a_photo(monkeypatch):
    commands = []

    def noting(command, **options):
        commands.append(command)
        return run(command, **options)

    run = subprocess.run
    monkeypatch.setattr(read_apart.subprocess, "run", noting)
    read_apart.read_apart(LOOK, "me_and_anna.jpg")
    assert len(commands) == 1 and "anna" not in str(commands)


def webp_of(width, height):
    """A WebP that declares a size but holds almost no data."""
    head = b"\x2f" + struct.pack("<I", (width - 1) | (height - 1) << 14 | 1 << 28) + bytes(27)
    chunks = b"WEBPVP8L" + struct.pack("<I", len(head)) + head
    return b"RIFF" + struct.pack("<I", len(chunks)) + chunks


@pytest.mark.parametrize("size", [(16383, 16383), (10900, 10900), (7212, 7211)])
def test_a_webp_is_refused_by_its_header(size):
    """Pillow reserves memory for a WebP when it opens the file: up to 2.1 GB, all unused."""
    words = f"^x has {size[0]} x {size[1]} px, more than 52 million px: make it smaller first$"
    with pytest.raises(PhotoError, match=words):
        read_apart.read_apart(webp_of(*size), "x")


def child(lines, photo):
    """The exit code and the output of a child that runs these lines before its main."""
    code = f"import makeup_video.web.photo_child as c\n{lines}\nc.main()"
    command = [sys.executable, "-c", code]
    done = subprocess.run(
        command, input=b'"x"\n' + photo, capture_output=True, timeout=60, check=False
    )
    return done.returncode, done.stdout.split(b"\n")[0]


@on_linux
def test_limits_are_set_before_anything_is_decoded():
    lines = """
import resource as r
def read(photo, name, most_px, before_decoding, most_jpeg_px):
    before_decoding()
    kinds = r.RLIMIT_AS, r.RLIMIT_CPU, r.RLIMIT_FSIZE
    raise c.MakeupVideoError(str([r.getrlimit(kind)[0] for kind in kinds]))
c.read_photo = read"""
    code, output = child(lines, b"")
    assert code == 0 and json.loads(json.loads(output)) == [1_000_000_000, 20, 0]


@on_linux
@pytest.mark.parametrize("kind", ["JPEG", "WEBP", "PNG"])
def test_a_picture_above_the_memory_limit_is_one_line(kind):
    file = io.BytesIO()
    Image.new("RGB", (4000, 4000), (200, 90, 80)).save(file, kind)
    code, output = child("c._DECODING_BYTES = 160_000_000", file.getvalue())
    assert code == 0 and isinstance(json.loads(output), str)
    assert json.loads(child("", file.getvalue())[1]) == [4000, 4000]


def test_the_child_starts_without_heavy_libraries():
    heavy = "av cv2 onnxruntime pyopencl simplejpeg uvicorn starlette"
    lines = f"import sys; print([n for n in {heavy.split()} if n in sys.modules]); sys.exit()"
    assert child(lines, b"")[1] == b"[]"


BROKEN = {
    "crashes": "import os, signal; os.kill(os.getpid(), signal.SIGKILL)",
    "fails": "raise MemoryError",
    "hangs": "import time; time.sleep(600)",
}


@pytest.fixture(params=BROKEN)
def broken(request, monkeypatch, tmp_path):
    """Replace the decoder by one that crashes, fails or hangs; returns the expected message."""
    (tmp_path / "broken_child.py").write_text(BROKEN[request.param])
    monkeypatch.setenv("PYTHONPATH", os.fspath(tmp_path))
    monkeypatch.setattr(read_apart, "_MODULE", "broken_child")
    monkeypatch.setattr(read_apart, "_SECONDS", 1.0 if request.param == "hangs" else 60.0)
    return "takes too long to read" if request.param == "hangs" else "cannot be read: save it again"


def test_a_decoder_that_crashes_is_one_line_on_the_page(broken):
    show = StandIn()
    show.reads = read_look
    with serving(show) as url, Page(url) as page:
        answer = page.post("/photo", LOOK, x_file_name="x.jpg")
        assert answer.status_code == 422
        assert answer.json()["error"].startswith(f"x.jpg {broken}")
        assert "\n" not in answer.json()["error"] and show.look == RED
        show.show(3)
        assert page.picture()[0] == 3


def test_without_a_process_the_visitor_is_asked_to_try_again(monkeypatch):
    monkeypatch.setattr(read_apart.sys, "executable", "/nowhere/python")
    with pytest.raises(PhotoError, match=r"^x cannot be read now: .*; try again later$"):
        read_apart.read_apart(LOOK, "x")


def test_modules_in_the_working_folder_are_not_imported(monkeypatch, tmp_path):
    (tmp_path / "PIL.py").write_text("raise SystemExit(3)")
    monkeypatch.chdir(tmp_path)
    assert read_apart.read_apart(LOOK, "x").shape == (1200, 1024, 3)


def test_the_largest_accepted_picture_is_read():
    side = int(photo_child.MOST_PX**0.5)
    photo = cv2.imencode(".png", np.full((side, side, 3), 90, np.uint8))[1].tobytes()
    assert read_apart.read_apart(photo, "x").shape == (-(-side // 2), -(-side // 2), 3)


def test_a_jpeg_of_108_megapixels_is_read():
    luma, chroma = np.full((9000, 12000), 120, np.uint8), np.full((4500, 6000), 150, np.uint8)
    photo = simplejpeg.encode_jpeg_yuv_planes(luma, chroma, chroma)
    assert read_apart.read_apart(bytes(photo), "x").shape == (2250, 3000, 3)


def test_a_jpeg_beyond_what_phones_take_is_refused():
    photo = bytearray(simplejpeg.encode_jpeg(np.zeros((8, 8, 3), np.uint8)))
    at = photo.index(b"\xff\xc0") + 5  # height and width in the frame header
    photo[at : at + 4] = struct.pack(">HH", 15_000, 15_000)
    with pytest.raises(PhotoError, match=r"^x has 15000 x 15000 px, more than 220 million px"):
        read_apart.read_apart(bytes(photo), "x")
