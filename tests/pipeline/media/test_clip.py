"""Packets and chapters inside a trim move with it; those outside are dropped."""

from fractions import Fraction
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.media.clip import Clip

BASE = Fraction(1, 1000)
CLIP = Clip(Fraction(2), Fraction(5), Fraction(2))  # seconds 2 to 5, which become 0 to 3


def packet(start_ms, duration_ms=100, kind="audio", **more):
    stream = SimpleNamespace(type=kind, disposition=0)
    times = {"pts": start_ms, "dts": start_ms, "duration": duration_ms, "time_base": BASE}
    return SimpleNamespace(**{**times, "stream": stream, **more})


@given(st.integers(-1000, 9000))
def test_a_whole_video_keeps_every_packet_as_it_is(start_ms):
    sound = packet(start_ms)
    assert Clip().take(sound) and (sound.pts, sound.dts, sound.duration) == (start_ms,) * 2 + (100,)


@given(st.integers(-1000, 9000))
def test_sound_inside_the_clip_moves_by_the_shift(start_ms):
    sound = packet(start_ms)
    assert CLIP.take(sound) == (2000 <= start_ms < 5000)
    if 2000 <= start_ms < 5000:
        assert (sound.pts, sound.dts, sound.duration) == (start_ms - 2000, start_ms - 2000, 100)


@pytest.mark.parametrize(
    ("start_ms", "duration_ms", "want"),
    [
        (0, 2000, None),  # ends where the clip begins
        (0, 2500, (0, 500)),  # on screen when the clip begins
        (2500, 1000, (500, 1000)),
        (4500, 1000, (2500, 500)),  # on screen when the clip ends
        (0, 9000, (0, 3000)),
        (5000, 1000, None),
    ],
)
def test_subtitles_are_cut_to_the_clip(start_ms, duration_ms, want):
    text = packet(start_ms, duration_ms, "subtitle")
    assert CLIP.take(text) == (want is not None)
    if want is not None:
        assert (text.pts, text.duration) == want


def test_packets_without_a_time_are_kept():
    assert CLIP.take(packet(0, pts=None, dts=None))


def test_chapters_are_cut_and_moved_and_others_dropped():
    spans = [(0, 1000), (1000, 3000), (3000, 4000), (4000, 9000), (5000, 9000)]
    chapters = [
        {"id": n, "start": a, "end": b, "time_base": BASE} for n, (a, b) in enumerate(spans)
    ]
    kept = [(c["id"], c["start"], c["end"]) for c in CLIP.chapters(chapters)]
    assert kept == [(1, 0, 1000), (2, 1000, 2000), (3, 2000, 3000)]
    assert Clip().chapters(chapters) is chapters


@given(start_ms=st.integers(0, 4000), length_ms=st.integers(0, 3000))
def test_words_before_a_late_clock_go_and_sound_stays(start_ms, length_ms):
    late = Clip(shift=Fraction(2))  # nothing is cut
    sound, text = packet(start_ms), packet(start_ms, length_ms, "subtitle")
    assert late.take(sound) and sound.pts == start_ms - 2000
    assert late.take(text) == (start_ms + length_ms > 2000)
    if start_ms + length_ms > 2000:
        assert text.pts == max(0, start_ms - 2000)
        assert text.pts + text.duration == start_ms + length_ms - 2000
    chapter = {"id": 1, "start": start_ms, "end": start_ms + length_ms, "time_base": BASE}
    kept = [(one["start"], one["end"]) for one in late.chapters([chapter])]
    end_ms = start_ms + length_ms - 2000
    there = end_ms > max(0, start_ms - 2000)
    assert kept == ([(max(0, start_ms - 2000), end_ms)] if there else [])
