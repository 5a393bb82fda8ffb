"""The timecode of an excerpt is the name that a frame counter gives its first frame."""

from fractions import Fraction

import av
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Settings, process_video
from makeup_video.pipeline.media.timecode import moved_timecode
from media import add_video, encode_frames
from rich_clips import rich_clip

NTSC = Fraction(30000, 1001)


def names(whole, dropped, sign):
    """All names of the frames of twelve minutes, one after another."""
    for minute in range(12):
        for second in range(60):
            for frame in range(whole):
                if second or frame >= dropped or not minute % 10:
                    yield f"00:{minute:02}:{second:02}{sign}{frame:02}"


COUNTERS = {
    (25, ":"): list(names(25, 0, ":")),
    (30, ";"): list(names(30, 2, ";")),
    (60, "."): list(names(60, 4, ".")),
    (50, ";"): list(names(50, 0, ";")),  # mislabelled: no drop frame at this rate
}


@given(st.sampled_from(list(COUNTERS)), st.integers(0, 17000), st.integers(0, 17000))
def test_a_moved_timecode_is_what_a_counter_says(kind, one, other):
    rate = kind[0] * (Fraction(1) if kind[1] == ":" else Fraction(1000, 1001))
    counter = COUNTERS[kind]
    first, last = sorted((one, other))
    moved = moved_timecode(counter[first], (last - first) / rate, rate)
    assert moved == counter[last]
    assert moved_timecode(moved, (first - last) / rate, rate) == counter[first]


@pytest.mark.parametrize(
    ("text", "seconds", "rate", "want"),
    [
        ("10:11:12:13", 1, 30, "10:11:13:13"),
        ("23:59:59:24", Fraction(1, 25), 25, "00:00:00:00"),
        ("00:59:59;29", 1 / NTSC, NTSC, "01:00:00;00"),
        ("01:00:59;29", 1 / NTSC, NTSC, "01:01:00;02"),
        ("00:00:00:119", Fraction(1, 120), 120, "00:00:01:000"),
        ("noon", 1, 25, "noon"),
        ("10:11:12:13", 1, 0, "10:11:12:13"),
    ],
)
def test_timecode_goes_on_over_minutes_hours_and_days(text, seconds, rate, want):
    assert moved_timecode(text, Fraction(seconds), Fraction(rate)) == want


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv"])
def test_an_excerpt_has_the_timecode_of_its_first_frame(tmp_path, end):
    src, dst = rich_clip(tmp_path / "in.mov"), tmp_path / f"out{end}"
    with av.open(str(src)) as container:
        rate = container.streams.video[0].average_rate
    process_video(src, dst, None, Settings(start_seconds=Fraction(10) / rate))
    with av.open(str(dst)) as container:
        metadata = {**container.metadata, **container.streams.video[0].metadata}
        (got,) = {value for key, value in metadata.items() if key.lower() == "timecode"}
    assert got == moved_timecode("01:02:03:04", Fraction(10) / rate, rate) != "01:02:03:04"


def test_the_timecode_of_a_late_video_counts_from_its_frames(tmp_path):
    """The file's clock begins at one second, where its first frame has its timecode."""
    with av.open(str(tmp_path / "in.mkv"), "w") as out:
        out.metadata["timecode"] = "01:00:00:00"
        video = add_video(out, options={"g": "15", "bf": "0"})
        encode_frames(out, video, range(30, 90))
    cut = Settings(start_seconds=Fraction(3, 2))
    process_video(tmp_path / "in.mkv", tmp_path / "out.mkv", None, cut)
    with av.open(str(tmp_path / "out.mkv")) as container:
        metadata = {**container.metadata, **container.streams.video[0].metadata}
        (got,) = {value for key, value in metadata.items() if key.lower() == "timecode"}
    assert got == "01:00:01:15"
