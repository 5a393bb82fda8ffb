"""H.264 for pages: right colours, a packet for each picture, key frames when they are asked for."""

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.kernels.colour import HLG, PQ
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.transform import upright_rgb
from makeup_video.pipeline.images.jpeg import PreviewJpeg
from makeup_video.pipeline.live.preview_video import PreviewVideo
from people import clip, frame_of


def decoded(packets):
    """(H, W, 3) uint8 RGB of each packet; like a browser, the decoder gets the packets alone."""
    context = av.CodecContext.create("h264", "r")
    frames = [frame for data in packets for frame in context.decode(av.Packet(data))]
    frames += context.decode(None)
    for frame in frames:
        assert frame.color_range == 1 and frame.colorspace == 1
    return [frame.to_ndarray(format="rgb24", src_colorspace="ITU709") for frame in frames]


def encoded(video, frame, **options):
    return video(frame.planes, frame.chroma, frame.bit_depth, frame.tags, **options)


@pytest.mark.parametrize(("matrix", "full_range"), [(1, False), (5, True), (5, False)])
def test_colours_are_those_of_the_frame(matrix, full_range):
    frame = frame_of(clip(1)[0], 0, matrix=matrix, full_range=full_range)
    want = upright_rgb(frame).astype(int)
    data, is_key = encoded(PreviewVideo(), frame)
    (got,) = decoded([data])
    assert is_key
    # quantisation: a JPEG of this quality is as far off
    assert np.abs(got - want).mean() < 2.5
    # each conversion rounds once
    assert np.abs(got.mean((0, 1)) - want.mean((0, 1))).max() < 1


@pytest.mark.parametrize("transfer", [PQ, HLG])
def test_hdr_frames_look_as_they_do_as_jpeg(transfer):
    ramp = np.linspace(0, 1023, 256).astype(np.uint16)
    planes = [np.tile(ramp, (64, 1)), *[np.full((32, 128), 512, np.uint16)] * 2]
    tags = ColourTags(9, 1, transfer, 9)
    data, _ = PreviewVideo()(planes, (2, 2), 10, tags)
    jpeg = PreviewJpeg(100)(planes, (2, 2), 10, tags)
    (got,) = decoded([data])
    context = av.CodecContext.create("mjpeg", "r")
    want = [*context.decode(av.Packet(jpeg)), *context.decode(None)][0].to_ndarray(format="rgb24")
    assert np.abs(got.astype(int) - want).mean() < 3  # the ramp is quantised coarsely


@settings(max_examples=15, deadline=None)
@given(
    size_wh=st.tuples(st.integers(2, 70), st.integers(2, 70)),
    chroma=st.sampled_from([(1, 1), (2, 1), (2, 2), (4, 1), (4, 4)]),
    grey=st.booleans(),
)
def test_any_size_and_subsampling_gives_a_key_frame(size_wh, chroma, grey):
    width, height = size_wh
    small = -(-height // chroma[1]), -(-width // chroma[0])
    planes = [np.full((height, width), 90, np.uint8)]
    planes += [] if grey else [np.full(small, 128, np.uint8)] * 2
    data, is_key = PreviewVideo()(planes, chroma, 8, ColourTags(1, 1))
    (got,) = decoded([data])
    assert is_key and got.shape == (height // 2 * 2, width // 2 * 2, 3)
    assert np.abs(got.astype(int) - round((90 - 16) * 255 / 219)).max() <= 3


def test_key_frames_come_first_on_request_and_with_a_new_size():
    video = PreviewVideo()
    frames = [frame_of(one, 0) for one in clip(6)]
    small = frame_of(clip(1)[0][:200, :300], 0)
    keys = [encoded(video, frame, key=number == 3)[1] for number, frame in enumerate(frames)]
    assert keys == [True, False, False, True, False, False]
    assert encoded(video, small)[1] and not encoded(video, small)[1]


def test_a_decoder_may_begin_at_any_key_frame():
    video = PreviewVideo()
    packets = [encoded(video, frame_of(one, 0), key=n == 2)[0] for n, one in enumerate(clip(4))]
    whole, late = decoded(packets), decoded(packets[2:])
    assert np.array_equal(whole[3], late[1])
    assert len(packets[3]) < len(packets[2]) / 2


def test_large_pictures_are_halved():
    planes = [np.full((120, 400), 90, np.uint8), *[np.full((60, 200), 128, np.uint8)] * 2]
    data, _ = PreviewVideo(limit_px=200)(planes, (2, 2), 8, ColourTags(1, 1))
    assert decoded([data])[0].shape == (60, 200, 3)


def test_the_planes_stay_as_they_are():
    frame = frame_of(clip(1)[0], 0)
    before = [plane.copy() for plane in frame.planes]
    encoded(PreviewVideo(), frame)
    assert all(np.array_equal(*pair) for pair in zip(before, frame.planes, strict=True))
