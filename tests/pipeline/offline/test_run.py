"""One run over a file: the part that is read, the threads, the report."""

import os
from contextlib import closing
from fractions import Fraction
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Settings, UsageError, process_video
from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.media.codecs import CODECS
from makeup_video.pipeline.media.input_file import open_video
from makeup_video.pipeline.offline import encoding, video
from media import decoded, make_clip, packets_of, picture, times_of
from whole_files import HALF_TICK_MKV, through


@pytest.mark.parametrize("end", [".mp4", ".mkv"])
def test_trimming_keeps_the_chosen_part_and_starts_it_at_zero(tmp_path, end):
    src = make_clip(tmp_path / "in.mp4", frames=90, audio="aac", options={"g": "30"})
    dst = tmp_path / f"out{end}"
    report = process_video(
        src, dst, None, Settings(start_seconds=Fraction("1.01"), end_seconds=Fraction(2))
    )
    want = [t for t in times_of(src) if Fraction("1.01") <= t < 2]
    assert report.frames_in == report.frames_out == len(want)
    half_tick = HALF_TICK_MKV if end == ".mkv" else 0
    assert all(abs(a - want[0] - b) <= half_tick for a, b in zip(want, times_of(dst), strict=True))
    sound = packets_of(dst, "audio")
    original = {data: seconds for seconds, data in packets_of(src, "audio")}
    assert 0.9 < len(sound) * 1024 / 48000 < 1.0
    for seconds, data in sound:  # in sync: every packet moved as far as the video
        assert abs(original[data] - want[0] - seconds) <= Fraction(1, 1000)


def test_trimming_counts_from_where_the_file_begins(tmp_path):
    """The timestamps of a recorded broadcast begin at a time of day, not at 0."""
    first = 90000 * 3600
    src = make_clip(
        tmp_path / "in.ts", pts=[first + 3000 * i for i in range(90)], time_base=Fraction(1, 90000),
        options={"g": "15"},
    )  # fmt: skip
    report = process_video(
        src, tmp_path / "out.mp4", None,
        Settings(start_seconds=Fraction(1), end_seconds=Fraction(2)),
    )  # fmt: skip
    assert report.frames_out == 30
    assert times_of(tmp_path / "out.mp4")[0] == 0


def test_the_output_may_not_be_the_input(tmp_path):
    src = make_clip(tmp_path / "in.mp4")
    before = src.read_bytes()
    os.link(src, tmp_path / "same.mp4")
    for name in ("in.mp4", "same.mp4"):
        with pytest.raises(UsageError, match="output is the input"):
            process_video(src, tmp_path / name, None, Settings(overwrite=True))
    assert src.read_bytes() == before


def test_an_output_of_bytes_is_refused_in_one_line(tmp_path):
    with pytest.raises(TypeError, match=r"dst must be a str or a Path, got bytes: os\.fsdecode"):
        process_video(make_clip(tmp_path / "in.mp4"), b"out.mp4")


def test_the_report_counts_bytes_frames_and_stages(tmp_path):
    src = make_clip(tmp_path / "in.mp4", audio="aac")
    report = through(src, tmp_path / "out.mp4").to_dict()
    assert report["bytes_in"] == src.stat().st_size
    assert report["bytes_out"] == (tmp_path / "out.mp4").stat().st_size
    assert report["stages"]["encode"]["items"] == 12
    assert report["peak_memory_bytes"] > 1e7
    assert report["media_seconds"] == pytest.approx(0.4)
    assert report["dropped"] == report["converted"] == report["conversions"] == []


@pytest.mark.parametrize(
    ("cores", "threads", "expected"),
    [
        (1, (None, None), (1, 0)),
        (2, (None, None), (1, 0)),
        (8, (None, None), (4, 0)),
        (8, (3, 2), (3, 2)),
        (8, (0, 0), (0, 0)),
    ],
)
def test_codecs_get_threads_by_cores_or_as_asked(tmp_path, monkeypatch, cores, threads, expected):
    thread_counts = {}
    decoder, encoder = video.Decoder, encoding.VideoEncoder

    def decode(*args, threads, **options):
        thread_counts["decode"] = threads
        return decoder(*args, threads=threads, **options)

    def encode(*args):
        thread_counts["encode"] = args[-2]  # before the note
        return encoder(*args)

    monkeypatch.setattr(video, "Decoder", decode)
    monkeypatch.setattr(encoding, "VideoEncoder", encode)
    monkeypatch.setattr(encoding, "cores", lambda: cores)
    src = make_clip(tmp_path / "in.mp4", frames=3)
    decoder_threads, encoder_threads = threads
    through(
        src, tmp_path / "out.mp4", decoder_threads=decoder_threads, encoder_threads=encoder_threads
    )
    assert (thread_counts["decode"], thread_counts["encode"]) == expected


@pytest.mark.parametrize(("compare", "count"), [(False, 0), (True, 8)])
def test_before_and_after_count_as_one_large_frame(tmp_path, monkeypatch, compare, count):
    monkeypatch.setattr(encoding, "VideoEncoder", lambda *words: words[-2])  # before the note
    monkeypatch.setattr(encoding, "cores", lambda: 8)
    monkeypatch.setattr(encoding, "_LARGE_PX", 2 * 96 * 64)
    with closing(open_video(make_clip(tmp_path / "in.mp4", frames=3))) as source:
        settings = Settings(compare=compare)
        chosen = encoding.choose_encoding(source, tmp_path / "out.mp4", settings)
        assert chosen.encoder(None, source, None) == count


def test_planes_reach_the_encoder_unconverted(tmp_path):
    """The decoder's own bytes reach the encoder: a lossless codec gives them back."""
    src = make_clip(tmp_path / "in.mp4", frames=8, options={"bf": "2"})
    process_video(src, tmp_path / "out.mkv", None, Settings(codec="ffv1"))
    want = [bytes(plane) for frame in decoded(src) for plane in frame.planes]
    got = [bytes(plane) for frame in decoded(tmp_path / "out.mkv") for plane in frame.planes]
    assert want == got
    assert picture(0, 8, 8).format.name == "yuv420p"


@given(frame_px=st.integers(1, 40_000_000), bit_depth=st.sampled_from([8, 10, 12]))
def test_few_bytes_of_frames_wait_between_two_threads(frame_px, bit_depth):
    source = SimpleNamespace(frame_px=frame_px, bit_depth=bit_depth)
    count, frame_bytes = video.channel_frames(source), frame_px * 1.5 * (2 if bit_depth > 8 else 1)
    assert count == 1 or count * frame_bytes <= 4.2e6
    assert count == 3 or (count + 1) * frame_bytes > 4.2e6


@pytest.mark.parametrize(("height_px", "waiting"), [(720, 3), (1080, 1)])
def test_a_run_bounds_its_channels_by_the_size_of_a_frame(tmp_path, height_px, waiting):
    src = make_clip(tmp_path / "in.mp4", frames=3, width=height_px * 16 // 9, height=height_px)
    report = process_video(src, tmp_path / "out.mp4")
    assert {one["capacity"] for one in report.channels.values()} == {waiting}


@given(frame_px=st.integers(1, 40_000_000), wanted=st.none() | st.integers(0, 9))
def test_encoders_of_large_frames_start_a_thread_a_core(frame_px, wanted):
    h264, hevc = CODECS["h264"], CODECS["hevc"]
    count = encoding.encoder_threads(h264, frame_px, wanted)
    if wanted is not None:
        assert count == wanted
    else:
        assert count == (cores() if frame_px >= 6e6 else 0)
        assert encoding.encoder_threads(hevc, frame_px) == 0
