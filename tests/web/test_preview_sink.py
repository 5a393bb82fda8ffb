"""The pictures of a live run for pages: JPEG and H.264, each only where a page can use it."""

import av
import numpy as np
import pytest
from makeup_video.pipeline import EncodeError
from makeup_video.pipeline.frames.transform import upright_rgb
from makeup_video.pipeline.images.jpeg import PreviewJpeg
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE, LivePicture
from makeup_video.pipeline.live.preview_video import PreviewVideo
from makeup_video.web import preview_sink
from makeup_video.web.preview_sink import PreviewSink
from makeup_video.web.session import Wanted
from people import clip, frame_of

BOTH, VIDEO, KEY = Wanted(True, True), Wanted(False, True), Wanted(False, True, True)
RGB8 = clip(1)[0]


def picture(pts=0, before=False):
    frame = frame_of(RGB8, pts, time_base=LIVE_TIME_BASE)
    return LivePicture(frame, tuple(plane // 2 for plane in frame.planes) if before else None)


@pytest.fixture
def watched():
    """A sink, and the list of what it pushes."""
    sink, pushed = PreviewSink(PreviewJpeg(), PreviewVideo), []
    sink.push = pushed.append
    return sink, pushed


def decoded(packets):
    context = av.CodecContext.create("h264", "r")
    frames = [frame for data, _ in packets for frame in context.decode(av.Packet(data))]
    return [frame.to_ndarray(format="rgb24") for frame in frames + context.decode(None)]


def test_only_what_pages_want_is_made(watched):
    sink, pushed = watched
    for wanted in (Wanted(), VIDEO, BOTH, Wanted(False, False)):
        sink.wanted = wanted
        sink(picture())
    made = [(one.jpeg is not None, one.video is not None) for one in pushed]
    assert made == [(True, False), (False, True), (True, True)]
    assert [one.video.number for one in pushed if one.video] == [1, 2]
    assert sink.sent == 4


def test_packets_decode_to_the_picture_and_the_one_before(watched):
    sink, pushed = watched
    sink.wanted = VIDEO
    sink(picture(1))
    sink.compares = True
    for pts in (2, 3):
        sink(picture(pts, before=True))
    sink.compares = False
    sink(picture(4, before=True))
    videos = [one.video for one in pushed]
    assert [video.painted[1] for video in videos] == [True, False, False, False]
    assert [video.before and video.before[1] for video in videos] == [None, True, False, None]
    want = upright_rgb(picture().frame).astype(int)
    for got in decoded([video.painted for video in videos]):
        assert np.abs(got - want).mean() < 3
    assert decoded([videos[1].before, videos[2].before])[1].mean() < want.mean() * 0.8


def test_key_frames_are_rare_however_often_they_are_wanted(watched, monkeypatch):
    sink, pushed = watched
    clock = iter(np.arange(100, 200, preview_sink.KEY_SECONDS / 4))
    monkeypatch.setattr(preview_sink.time, "monotonic", lambda: next(clock))
    sink.wanted = KEY
    for pts in range(12):
        sink(picture(pts))
    assert [n for n, one in enumerate(pushed) if one.video.painted[1]] == [0, 4, 8]


def test_the_newest_picture_can_be_pushed_again(watched):
    sink, pushed = watched
    sink.show_again()
    assert pushed == []
    sink(picture(7))
    sink.wanted = KEY
    sink.show_again()
    assert [one.pts_us for one in pushed] == [7, 7]
    assert pushed[1].video.painted[1] and pushed[1].jpeg is None


def test_a_failing_encoder_is_left_with_a_line(watched):
    sink, pushed = watched

    def refuse():
        raise EncodeError("libx264 refuses")

    lines = []
    sink = PreviewSink(PreviewJpeg(), refuse, lines.append)
    sink.push, sink.wanted = pushed.append, VIDEO
    assert sink.has_video
    sink(picture())
    assert not sink.has_video and pushed[0].video is None and lines == ["libx264 refuses"]
    sink.wanted = Wanted()
    sink(picture())
    assert pushed[1].jpeg is not None
    assert not PreviewSink(PreviewJpeg()).has_video
