"""A video of irregular times: mp4 and mov are as long as its pictures, for every reader."""

import struct
from fractions import Fraction

import av
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Settings, process_video
from makeup_video.pipeline.media.mp4_boxes import boxes_at, whole_file
from makeup_video.pipeline.media.mp4_length import TrackLength
from media import make_clip, times_of

TICK = Fraction(1, 1000)
SCREEN = [0, 33, 66, 1000, 1033, 3000, 3033, 6000]  # ms: a screen recording


def clip(path, pts, last):
    """A video without B-frames whose last frame is shown for `last` ms."""
    return make_clip(
        path, pts=pts, last=last, time_base=TICK, options={"bf": "0"},
        container_options={"video_track_timescale": "1000"},
    )  # fmt: skip


def header_seconds(path):
    """The length by the movie header, and by the steps between decoding times, in seconds."""
    with path.open("rb") as file:

        def numbers(kind, at, *names):
            box = next(boxes_at(file, whole_file(path), b"moov", *names))
            file.seek(box.begin + at)
            return [n for (n,) in struct.iter_unpack(kind, file.read(box.end - box.begin - at))]

        ticks, movie = numbers(">I", 12, b"mvhd")[:2]
        media_ticks = numbers(">I", 12, b"trak", b"mdia", b"mdhd")[0]
        steps = numbers(">I", 8, b"trak", b"mdia", b"minf", b"stbl", b"stts")
    total = sum(a * b for a, b in zip(steps[::2], steps[1::2], strict=True))
    return Fraction(movie, ticks), Fraction(total, media_ticks)


@pytest.mark.parametrize("codec_end", [("h264", ".mp4"), ("hevc", ".mov"), ("av1", ".mp4")])
@pytest.mark.parametrize(
    ("pts", "last"),
    [
        (SCREEN, 33),
        (range(0, 1000, 100), 2000),  # the last frame stands still
        ([0, 3000, 6000, 6033, 6066], 33),
        ([0, 33, 66, 99, 3000], 33),
        ([500], 2000),
    ],
)
def test_an_irregular_video_has_its_length(tmp_path, codec_end, pts, last):
    codec, end = codec_end
    src, dst, seconds = tmp_path / "in.mp4", tmp_path / f"out{end}", pts[-1] + last - pts[0]
    clip(src, pts, last)
    report = process_video(src, dst, None, Settings(codec=codec))
    movie_seconds, steps_seconds = header_seconds(dst)
    assert movie_seconds == (pts[-1] + last) * TICK
    assert steps_seconds >= seconds * TICK
    assert times_of(dst) == [one * TICK for one in pts]
    assert report.media_seconds == pytest.approx(seconds / 1000)
    with av.open(str(dst)) as container:
        assert container.streams.video[0].duration == seconds
        assert container.duration == pytest.approx(seconds * 1000, abs=1000)


@pytest.mark.parametrize("codec", ["h264", "hevc"])
@pytest.mark.parametrize("settings", [{}, {"start_seconds": Fraction("0.5")}])
def test_a_last_frame_that_stands_is_read_back(tmp_path, codec, settings):
    """The picture shown last is not decoded last, so its step says nothing of its length."""
    src = clip(tmp_path / "in.mp4", range(0, 1000, 100), 2000)
    process_video(src, tmp_path / "ours.mp4", None, Settings(codec=codec))
    report = process_video(tmp_path / "ours.mp4", tmp_path / "out.mkv", None, Settings(**settings))
    assert report.media_seconds == pytest.approx(2.4 if settings else 2.9)


def test_a_file_cut_short_does_not_stand_still_to_its_end(tmp_path):
    src = clip(tmp_path / "in.mp4", range(0, 1000, 100), 2000)
    process_video(src, tmp_path / "ours.mp4")  # its index is in front
    data = (tmp_path / "ours.mp4").read_bytes()
    (tmp_path / "ours.mp4").write_bytes(data[: len(data) * 9 // 10])
    report = process_video(tmp_path / "ours.mp4", tmp_path / "out.mkv")
    assert report.truncated and report.media_seconds < 1


class Packet:
    def __init__(self, pts, dts, duration):
        self.pts, self.dts, self.duration = pts, dts, duration


@given(
    steps=st.lists(st.integers(1, 3000), min_size=1, max_size=12),
    delay=st.integers(0, 3),
    order=st.randoms(use_true_random=False),
)
def test_the_last_packet_alone_is_changed(steps, delay, order):
    """Times as x264 gives them: decoded when the picture `delay` places before is shown."""
    shown = [sum(steps[:at]) for at in range(len(steps) + 1)]
    end, count, delay = shown[-1], len(steps), min(delay, len(steps) - 1)
    early = shown[delay]
    dts = [shown[at - delay] if at >= delay else shown[at] - early for at in range(count)]
    decoded = _order(count, delay, order)
    packets = [
        Packet(shown[index], time, steps[index]) for index, time in zip(decoded, dts, strict=True)
    ]
    length, written = TrackLength(), []
    for packet in packets:
        written += length(packet)
    written += length.finish()
    assert written == packets and length.finish() == []
    last = packets[-1]
    kept = list(zip(decoded, dts, strict=True))[:-1]
    assert [(p.pts, p.dts, p.duration) for p in packets[:-1]] == [
        (shown[index], time, steps[index]) for index, time in kept
    ]
    assert last.pts == shown[decoded[-1]] and dts[-1] <= last.dts <= last.pts
    assert last.pts + last.duration <= end
    assert last.dts + last.duration + early >= end  # the steps add up to the whole length


def _order(count, delay, random):
    """An order of decoding in which no picture comes more than `delay` places late."""
    waiting, order = list(range(1, count)), [0]
    while waiting:
        late = waiting[0] + delay <= len(order)
        order.append(waiting.pop(0 if late else random.randrange(min(delay + 1, len(waiting)))))
    return order
