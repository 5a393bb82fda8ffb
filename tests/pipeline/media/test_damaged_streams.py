"""Damage beside the video: audio that does not decode, and timestamps beyond any clock."""

import random
import struct
from fractions import Fraction

import av
import pytest
from makeup_video.pipeline import OutputError, process_video
from makeup_video.pipeline.media.mux import Muxer
from media import make_clip, packets_of, picture, times_of

FRAMES = 12


@pytest.mark.parametrize(
    "error",
    [
        av.error.InvalidDataError(1094995529, "Invalid data found"),
        av.error.ArgumentError(22, "Invalid argument"),
        av.error.PatchWelcomeError(1163346256, "Not yet implemented in FFmpeg, patches welcome"),
        av.error.UndefinedError(50531338, "Error number -50531338 occurred"),
        av.error.UndefinedError(34, "Numerical result out of range"),
    ],
    ids=lambda error: str(error.errno),
)
@pytest.mark.parametrize("end", [".mkv", ".webm"])  # copied, and converted
def test_sound_that_ffmpeg_refuses_is_left_out(tmp_path, monkeypatch, error, end):
    src, refused = make_clip(tmp_path / "in.mp4", audio="aac", frames=FRAMES), []
    original_mux = Muxer._mux

    def refuse_audio(self, stream, packet):
        if stream.type == "audio" and len(refused) < 2:
            refused.append(1)
            raise error
        original_mux(self, stream, packet)

    monkeypatch.setattr(Muxer, "_mux", refuse_audio)
    report = process_video(src, tmp_path / f"out{end}")
    assert (report.frames_out, report.skipped_packets, report.damaged) == (FRAMES, 2, True)


@pytest.mark.parametrize("number", [28, 122, 27, 5, 12])  # disk full, quota, too large, I/O, memory
def test_a_full_disk_is_not_called_damage_of_the_input(tmp_path, monkeypatch, number):
    src = make_clip(tmp_path / "in.mp4", audio="aac", frames=FRAMES)
    original_mux = Muxer._mux

    def fill_the_disk(self, stream, packet):
        if stream.type == "audio":
            raise av.error.UndefinedError(number, "no room")
        original_mux(self, stream, packet)

    monkeypatch.setattr(Muxer, "_mux", fill_the_disk)
    with pytest.raises(OutputError, match="no room"):
        process_video(src, tmp_path / "out.mkv")
    assert [path.name for path in tmp_path.iterdir()] == ["in.mp4"]


@pytest.mark.parametrize("seed", range(8))
def test_random_damage_in_the_sound_never_stops_the_video(tmp_path, seed):
    src = make_clip(tmp_path / "in.mkv", audio="aac", frames=30)
    data, rng = bytearray(src.read_bytes()), random.Random(seed)
    for _, payload in packets_of(src, "audio")[2::3]:
        offset = data.index(payload)
        for _ in range(20):
            data[offset + rng.randrange(len(payload))] = rng.randrange(256)
    src.write_bytes(data)
    assert process_video(src, tmp_path / "out.webm").frames_out == 30


def ivf_with_times(path, times, tick):
    """Write VP9 into an IVF file. times are in ticks; tick is (numerator, denominator) seconds."""
    make_clip(path, "vp9", frames=len(times))
    data = bytearray(path.read_bytes())
    struct.pack_into("<II", data, 16, tick[1], tick[0])
    offset = 32
    for pts in times:
        struct.pack_into("<Q", data, offset + 4, pts)
        offset += 12 + struct.unpack_from("<I", data, offset)[0]
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("end", [".mp4", ".mkv", ".webm"])
def test_a_time_beyond_any_clock_is_mended(tmp_path, end):
    src = ivf_with_times(tmp_path / "in.ivf", [0, 1, 2**61, 3], (1, 30))
    report = process_video(src, tmp_path / f"out{end}")
    assert report.frames_out == 4 and report.mended_times >= 1
    times = times_of(tmp_path / f"out{end}")
    assert times == sorted(times) and len(set(times)) == 4


def test_times_of_this_century_are_not_called_damage(tmp_path):
    """Surveillance cameras count seconds from 1970."""
    epoch = 1_790_000_000
    src = tmp_path / "in.mkv"
    with av.open(str(src), "w") as out:
        stream = out.add_stream("libx264", rate=25, options={"preset": "ultrafast", "bf": "0"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for index in range(6):
            frame = picture(index, 64, 48)
            frame.pts, frame.time_base = epoch * 25 + index, Fraction(1, 25)
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))
    report = process_video(src, tmp_path / "out.mkv")
    assert report.mended_times == 0 and times_of(tmp_path / "out.mkv") == times_of(src)
