"""A clock that jumps goes on: no frame and no sound is lost, and they stay together."""

from fractions import Fraction
from itertools import accumulate, pairwise
from types import SimpleNamespace

import av
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Settings, process_video
from makeup_video.pipeline.media.clock_jumps import ClockJumps
from media import add_video, encode_frames, packets_of, times_of, tone


def recording(path, begins, frames=60):
    """A stream of 30 frames a second with sound, whose clock begins at some second."""
    with av.open(str(path), "w", container_options={"mpegts_copyts": "1", "muxdelay": "0"}) as out:
        video = add_video(out, "h264", time_base=Fraction(1, 90000))
        audio = out.add_stream("aac", rate=48000, layout="stereo")
        encode_frames(out, video, [begins * 90000 + 3000 * i for i in range(frames)])
        tone(out, audio, frames / 30, start_seconds=begins)
    return path.read_bytes()


def joined(folder, *begins):
    src = folder / "in.ts"
    src.write_bytes(b"".join(recording(folder / "part.ts", at) for at in begins))
    return src


@pytest.mark.parametrize("begins", [(4, 0), (2, 0, 0), (70, 50, 0)], ids=str)
@pytest.mark.parametrize("name", ["out.mp4", "out.mkv"])
def test_nothing_is_lost_where_the_clock_jumps(tmp_path, name, begins):
    src, out = joined(tmp_path, *begins), tmp_path / name
    report = process_video(src, out)
    assert report.frames_out == 60 * len(begins) and not report.damaged
    assert (
        sum("since the clock jumps there" in text for text in report.converted) == len(begins) - 1
    )
    assert len(packets_of(out, "audio")) == len(packets_of(src, "audio"))
    for times in (times_of(out), [seconds for seconds, _ in packets_of(out, "audio")]):
        assert max(b - a for a, b in pairwise(times)) < 0.2
        assert times[-1] == pytest.approx(2 * len(begins), abs=0.3)


def test_sound_and_picture_stay_together_after_a_jump(tmp_path):
    src, out = joined(tmp_path, 4, 0), tmp_path / "out.mkv"
    process_video(src, out)
    sound = [seconds for seconds, _ in packets_of(out, "audio")]
    whole = packets_of(tmp_path / "part.ts", "audio")
    first = sound[len(sound) - len(whole)]  # where the second recording begins
    assert first - times_of(out)[60] == pytest.approx(
        whole[0][0] - times_of(tmp_path / "part.ts")[0], abs=0.002
    )


def test_a_video_whose_clock_jumps_is_painted_whole(tmp_path):
    src = joined(tmp_path, 4, 0)
    report = process_video(src, tmp_path / "out.mp4", None, Settings(split_minutes=Fraction(1, 60)))
    assert report.frames_out == 120 and "clock jumps" in report.why_whole


@pytest.mark.parametrize("gap", [30, 3600])
def test_a_pause_stays_a_pause(tmp_path, gap):
    src = joined(tmp_path, 0, gap)
    report = process_video(src, tmp_path / "out.mkv")
    assert report.converted == [] and report.frames_out == 120
    assert times_of(tmp_path / "out.mkv")[-1] - times_of(tmp_path / "out.mkv")[0] > gap


def packet(kind, seconds):
    tick = Fraction(1, 90000)
    stream = SimpleNamespace(type=kind, index=("video", "audio", "subtitle").index(kind))
    ticks = round(seconds * 90000)
    return SimpleNamespace(stream=stream, time_base=tick, dts=ticks, pts=ticks, duration=3000)


def mended(sent):
    """The jumps that ClockJumps finds in packets, [(kind, seconds)], and their seconds after it."""
    jumps, moved = ClockJumps(SimpleNamespace(has_free_clock=True)), []
    for kind, seconds in sent:
        moved.append(packet(kind, seconds))
        jumps(moved[-1])
    return jumps.jumps, [one.pts / 90000 for one in moved]


def test_one_packet_astray_moves_nothing_else():
    sent = [
        ("video", 5),
        ("audio", 5),
        ("audio", 1),
        ("audio", 5.1),
        ("video", 5.1),
        ("audio", 5.2),
    ]
    jumps, times = mended(sent)
    assert jumps == []
    off = [time - seconds for time, (_, seconds) in zip(times, sent, strict=True)]
    assert [round(by, 3) for at, by in enumerate(off) if at != 2] == [0] * 5


def test_a_stream_joins_at_the_jump_that_the_others_have_made():
    sent = [
        ("video", 5),
        ("video", 0),
        ("video", 0.1),
        ("audio", 0.1),
        ("video", -2),
        ("video", -1.9),
    ]
    sent += [("audio", -1.9), ("audio", -1.8)]
    jumps, times = mended(sent)
    video, audio = (
        [time for time, (kind, _) in zip(times, sent, strict=True) if kind == wanted]
        for wanted in ("video", "audio")
    )
    assert len(jumps) == 2 and video == sorted(video)
    assert audio[1:] == pytest.approx([video[-1], video[-1] + 0.1])


def test_words_move_with_sound_and_picture():
    sent = [
        ("video", 5),
        ("audio", 5),
        ("subtitle", 5),
        ("audio", 0),
        ("video", 0),
        ("subtitle", 40),
    ]
    jumps, times = mended(sent)
    (_, by), *more = jumps
    assert not more and 5 < by < 5.1
    assert [time - seconds for time, (_, seconds) in zip(times, sent, strict=True)] == (
        pytest.approx([0, 0, 0, by, by, by])
    )


def test_words_that_stay_long_leave_no_gap_at_a_jump():
    _, times = mended([("video", 5), ("subtitle", 60), ("video", 0)])
    assert times[-1] == pytest.approx(5, abs=0.1)


@given(st.lists(st.fractions(min_value=Fraction(-9, 10), max_value=100), max_size=20))
def test_a_clock_that_never_jumps_back_stays(steps):
    sent = [("video", seconds) for seconds in accumulate(steps, initial=Fraction(100))]
    jumps, times = mended(sent)
    assert not jumps and times == [packet(*one).pts / 90000 for one in sent]
