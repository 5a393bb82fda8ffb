"""Source and painted frame side by side: both halves are exact in every layout and rotation."""

import subprocess
import sys
from fractions import Fraction

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import Look, Settings, process_video, product
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.display_matrix import turn_and_mirror_of
from makeup_video.pipeline.frames.frame import Frame, plane_views
from makeup_video.pipeline.frames.orientation import ORIENTATIONS, orientation_of
from makeup_video.pipeline.media.codecs import CODECS
from makeup_video.pipeline.media.side_by_side import SideBySide, side_by_side
from media import add_video, decoded, encode_frames, make_clip, picture, times_of
from people import clip, write_video

LAYOUTS = sorted({name for codec in CODECS.values() for name in codec.pix_fmts})
RED = Look(lips=product((180, 0, 46), "satin"))


def invert(frame):
    for plane in frame.writable_planes():
        plane[:] = (1 << frame.bit_depth) - 1 - plane
    return frame


def frame_of(pix_fmt, width, height, rotation_degrees=0, index=1):
    video_frame = picture(index, width, height, pix_fmt)
    video_frame.pts = 7
    return Frame(video_frame, 7, Fraction(1, 30), ColourTags(1, 1, 1, 1), rotation_degrees)


def copies(picture):
    depth = picture.format.components[0].bits
    return [plane.copy() for plane in plane_views(picture, depth)]


def assert_halves(frame, before, after, rotation_degrees):
    """Assert that the upright frame shows `before` on the left and `after` on the right."""
    turns = rotation_degrees // 90
    for both, old, new in zip(frame.planes, before, after, strict=True):
        upright, old, new = (np.rot90(plane, turns) for plane in (both, old, new))
        middle = upright.shape[1] // 2
        # an odd size grows at the stored right and bottom edge, by whole chroma samples
        top = upright.shape[0] - old.shape[0] if rotation_degrees in (90, 180) else 0
        for half, want in ((upright[:, :middle], old), (upright[:, middle:], new)):
            spare = half.shape[1] - want.shape[1]
            left = spare if rotation_degrees in (180, 270) else 0
            view = half[top : top + want.shape[0], left : left + want.shape[1]]
            np.testing.assert_array_equal(view, want)
            assert 0 <= spare <= 1


@pytest.mark.parametrize("rotation_degrees", [0, 90, 180, 270])
@pytest.mark.parametrize("pix_fmt", LAYOUTS)
def test_both_halves_are_exact_in_every_layout_and_rotation(pix_fmt, rotation_degrees):
    frame = frame_of(pix_fmt, 48, 32, rotation_degrees)
    before = copies(frame.picture)
    out = SideBySide(invert)(frame)
    after = copies(frame.picture)
    assert_halves(out, before, after, rotation_degrees)
    wide = rotation_degrees in (0, 180)
    assert (out.width_px, out.height_px) == ((96, 32) if wide else (48, 64))
    assert out.pix_fmt == pix_fmt and out.rotation_degrees == rotation_degrees
    assert (out.pts, out.time_base, out.tags) == (7, Fraction(1, 30), ColourTags(1, 1, 1, 1))


@given(st.integers(1, 33), st.integers(1, 33), st.sampled_from([0, 90, 180, 270]),
       st.sampled_from(
           ["yuv420p", "yuv422p", "yuv444p", "nv12", "yuv420p10le", "yuva420p"]))  # fmt: skip
@settings(deadline=None, max_examples=60)
def test_odd_sizes_grow_to_whole_chroma_samples(width, height, turned, pix_fmt):
    frame = frame_of(pix_fmt, width, height, turned)
    before = copies(frame.picture)
    out = SideBySide(invert)(frame)
    assert_halves(out, before, copies(frame.picture), turned)


def test_odd_sizes_grow_by_repeating_the_edge():
    out = SideBySide(invert)(frame_of("yuv420p", 5, 3))
    luma = out.planes[0]
    assert luma.shape == (4, 12)
    np.testing.assert_array_equal(luma[:, 5], luma[:, 4])
    np.testing.assert_array_equal(luma[3], luma[2])


@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuv422p10le", "yuva444p10le", "yuv444p"])
def test_an_unpainted_video_is_shown_twice(tmp_path, pix_fmt):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt=pix_fmt, audio="aac")
    dst = tmp_path / "out.mkv"
    report = process_video(src, dst, Look(), Settings(compare=True, codec="ffv1"))
    assert report.frames_out == 12 and list(report.stages) == ["decode", "compare", "encode"]
    assert times_of(dst) == times_of(src)
    for old, new in zip(decoded(src), decoded(dst), strict=True):
        for single, both in zip(copies(old), copies(new), strict=True):
            np.testing.assert_array_equal(both, np.concatenate([single, single], 1))


@pytest.mark.parametrize("rotation_degrees", [0, 90, 180, 270])
def test_the_source_is_on_the_left_the_painted_video_right(tmp_path, rotation_degrees):
    end = ".mov" if rotation_degrees else ".mkv"
    stored = write_video(tmp_path / "in.mkv", clip(3), rotation_degrees=rotation_degrees)
    if rotation_degrees:  # only Matroska holds FFV1, so Matroska must keep the rotation
        assert decoded(stored)[0].rotation % 360 == rotation_degrees
    plain, both = tmp_path / "plain.mkv", tmp_path / "both.mkv"
    assert process_video(stored, plain, RED, Settings(codec="ffv1")).painted_frames == 3
    process_video(stored, both, RED, Settings(codec="ffv1", compare=True))
    frames = zip(decoded(stored), decoded(plain), decoded(both), strict=True)
    for old, new, compared in frames:
        assert compared.rotation % 360 == rotation_degrees
        before, after = copies(old), copies(new)
        assert any((a != b).any() for a, b in zip(before, after, strict=True))
        frame = Frame(compared, 0, Fraction(1, 30), ColourTags(), rotation_degrees)
        assert_halves(frame, before, after, rotation_degrees)
    process_video(stored, tmp_path / f"out{end}", RED, Settings(compare=True))
    assert decoded(tmp_path / f"out{end}")[0].rotation % 360 == rotation_degrees


MIRRORED = {  # a, b, c, d of the display matrix: how the stored picture is shown
    (-1, 0, 0, 1): lambda p: p[:, ::-1],
    (1, 0, 0, -1): lambda p: p[::-1],
    (0, 1, 1, 0): lambda p: p.T,
    (0, -1, -1, 0): lambda p: p[::-1, ::-1].T,
}


@pytest.mark.parametrize("matrix", MIRRORED)
def test_mirrored_videos_have_the_source_on_the_left_too(tmp_path, matrix):
    show, unit = MIRRORED[matrix], 1 << 16
    with av.open(str(tmp_path / "in.mp4"), "w") as out:
        stream = add_video(out, size_wh=(96, 64))
        a, b, c, d = (unit * n for n in matrix)
        stream.set_display_matrix((a, b, 0, c, d, 0, 0, 0, 1 << 30))
        encode_frames(out, stream, range(2))
    src = decoded(tmp_path / "in.mp4")[0]
    frame = Frame(src, 0, Fraction(1, 30), ColourTags(1, 1, 1, 1), *turn_and_mirror_of(src))
    before = show(copies(src)[0])
    both = show(SideBySide(invert)(frame).planes[0])
    np.testing.assert_array_equal(both, np.concatenate([before, 255 - before], 1))


@pytest.mark.parametrize("codec_end", [("h264", ".mp4"), ("vp9", ".webm"), ("prores", ".mov")])
@pytest.mark.parametrize("aspect", [Fraction(1), Fraction(4, 3)])
def test_the_video_is_twice_as_wide_with_the_same_pixels(tmp_path, codec_end, aspect):
    codec, end = codec_end
    src = make_clip(tmp_path / "in.mp4", sample_aspect_ratio=aspect, frames=4)
    dst = tmp_path / f"out{end}"
    process_video(src, dst, None, Settings(codec=codec, compare=True))
    new = decoded(dst)[0]
    assert (new.width, new.height) == (192, 64)
    with av.open(str(dst)) as container:
        assert (container.streams.video[0].sample_aspect_ratio or 1) == aspect


@pytest.mark.parametrize("rotation_degrees", [0, 90])
def test_interlaced_videos_keep_their_fields(tmp_path, rotation_degrees):
    src = make_clip(
        tmp_path / "in.mp4", "mpeg4", size_wh=(96, 66), flags=1 << 18 | 1 << 29,
        rotation_degrees=rotation_degrees,
    )  # fmt: skip
    assert decoded(src)[0].interlaced_frame
    process_video(src, tmp_path / "out.mkv", None, Settings(codec="ffv1", compare=True))
    (old, *_), (new, *_) = decoded(src), decoded(tmp_path / "out.mkv")
    assert new.interlaced_frame
    if rotation_degrees:
        assert (new.width, new.height) == (96, 2 * 68)  # so that each row keeps its field
        np.testing.assert_array_equal(copies(new)[0][68 : 68 + 66], copies(old)[0])


def test_the_last_frame_keeps_its_length(tmp_path):
    src, dst = make_clip(tmp_path / "in.mp4", frames=10), tmp_path / "out.mp4"
    process_video(src, dst, None, Settings(compare=True))
    with av.open(str(dst)) as container:
        stream = container.streams.video[0]
        assert stream.duration * stream.time_base == Fraction(10, 30)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_pictures_are_joined_under_every_orientation(orientation):
    """Exif 2.32 (table 6) defines where row 0 and column 0 of a stored picture are."""
    store = {
        1: lambda p: p, 2: lambda p: p[:, ::-1], 3: lambda p: p[::-1, ::-1], 4: lambda p: p[::-1],
        5: lambda p: p.transpose(1, 0, 2), 6: lambda p: np.rot90(p, 1),
        7: lambda p: p[::-1, ::-1].transpose(1, 0, 2), 8: lambda p: np.rot90(p, -1),
    }[orientation]  # fmt: skip
    rng = np.random.default_rng(orientation)
    left, right = rng.integers(0, 65536, (2, 7, 5, 4)).astype(np.uint16)
    both = side_by_side(store(left), store(right), ORIENTATIONS[orientation])
    np.testing.assert_array_equal(both, store(np.concatenate([left, right], 1)))


def test_an_unknown_orientation_counts_as_none():
    left, right = np.zeros((2, 3, 3), np.uint8), np.ones((2, 3, 3), np.uint8)
    assert side_by_side(left, right, orientation_of(99)).shape == (2, 6, 3)


def test_comparing_loads_no_nets_and_no_opencl(tmp_path):
    make_clip(tmp_path / "in.mp4")
    code = (
        "import sys; from makeup_video.pipeline import Settings, process_video\n"
        "process_video('in.mp4', 'out.mp4')\n"
        "process_video('in.mp4', 'both.mp4', None, Settings(compare=True))\n"
        "heavy = {'cv2', 'onnxruntime', 'pyopencl'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path)
