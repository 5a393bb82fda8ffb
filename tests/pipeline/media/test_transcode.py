"""Streams that change codec keep their times and their content."""

from fractions import Fraction

import av
import numpy as np
import pytest
from makeup_video.pipeline import process_video
from makeup_video.pipeline.media.transcode import AudioConverter
from media import add_video, encode_frames, tone


@pytest.mark.parametrize(("source", "end", "codec"), [
    ("aac", ".webm", "opus"), ("pcm_s16le", ".webm", "opus"), ("ac3", ".webm", "opus"),
    ("flac", ".mov", "aac"),
])  # fmt: skip
@pytest.mark.parametrize("start_seconds", [0.0, 0.7])
@pytest.mark.parametrize("layout", ["mono", "stereo"])
def test_a_tone_stays_the_same_tone_at_the_same_time(
    tmp_path, source, end, codec, start_seconds, layout
):
    src, dst = tmp_path / "in.mkv", tmp_path / f"out{end}"
    with av.open(str(src), "w") as out:
        video = add_video(out)
        sound = out.add_stream(source, rate=44100, layout=layout)
        encode_frames(out, video, range(60))
        tone(out, sound, 1.0, hertz=441, start_seconds=start_seconds)
    report = process_video(src, dst)
    assert len(report.converted) == 1
    rate, samples, begin = decoded_audio(dst, codec)
    loud = np.flatnonzero(np.abs(samples) > 0.05)
    assert begin + loud[0] / rate == pytest.approx(start_seconds, abs=0.03)
    assert begin + loud[-1] / rate == pytest.approx(start_seconds + 1, abs=0.06)
    middle = samples[loud[0] + rate // 4 : loud[0] + rate * 3 // 4]
    spectrum = np.abs(np.fft.rfft(middle * np.hanning(len(middle))))
    assert np.argmax(spectrum) * rate / len(middle) == pytest.approx(441, abs=4)
    assert np.abs(middle).max() == pytest.approx(0.2, abs=0.04)


@pytest.mark.parametrize(("rate", "kept"), [(11024, 11025), (5512, 7350), (96001, 96000)])
def test_rates_that_the_codec_lacks_become_the_nearest(tmp_path, rate, kept):
    with av.open(str(tmp_path / "in.avi"), "w") as out:
        video = add_video(out, "mpeg4")
        sound = out.add_stream("pcm_u8", rate=rate, layout="mono")
        encode_frames(out, video, range(30))
        tone(out, sound, 1.0)
    report = process_video(tmp_path / "in.avi", tmp_path / "out.mp4")
    assert len(report.converted) == 1 and not report.damaged
    found, samples, _ = decoded_audio(tmp_path / "out.mp4", "aac")
    # the tone and AAC's last frame are whole pieces of 1024 samples
    assert found == kept and 1 <= len(samples) / found <= 1 + 1024 / rate + 1024 / found


def sound_of(samples, layout):
    """A frame of (N, channels) samples of 16 bits at 48 kHz, from time 0."""
    frame = av.AudioFrame.from_ndarray(samples.astype(np.int16).reshape(1, -1), "s16", layout)
    frame.sample_rate, frame.pts, frame.time_base = 48000, 0, Fraction(1, 48000)
    return frame


@pytest.mark.parametrize("end", ["webm", "mp4"])
@pytest.mark.parametrize("layout", ["5.0", "5.1", "6.1", "7.1"])
def test_a_converted_channel_stays_in_its_place(tmp_path, end, layout):
    """Each channel has a tone of its own, low enough for the channel of low frequencies."""
    src, dst = tmp_path / "in.mkv", tmp_path / f"out.{end}"
    names = [one.name for one in av.AudioLayout(layout).channels]
    hertz = {name: 20 + 10 * number for number, name in enumerate(names)}
    with av.open(str(src), "w") as out:
        video = add_video(out)
        sound = out.add_stream("flac", rate=48000, layout=layout)
        encode_frames(out, video, range(30))
        seconds = np.arange(48000)[:, None] / 48000
        samples = 9000 * np.sin(2 * np.pi * seconds * list(hertz.values()))
        out.mux(sound.encode(sound_of(samples, layout)))
        out.mux(sound.encode(None))
    process_video(src, dst)
    heard = tones_of(dst)
    # side and back are one in a layout that has only one of them
    same = {"SL": "BL", "SR": "BR"} if layout in ("5.0", "5.1") else {}
    heard = {same.get(name, name): tone for name, tone in heard.items()}
    if layout == "6.1" and end == "webm":  # 7.1 has no middle at the back
        assert {heard.pop("BL"), heard.pop("BR")} == {hertz.pop("BC")}
    assert {name: heard[name] for name in hertz} == hertz


def tones_of(path):
    """The loudest frequency of each channel, to 10 Hz."""
    with av.open(str(path)) as container:
        sound = container.streams.audio[0]
        # packed: PyAV 18 takes eight planes for nine
        packed = av.AudioResampler("s16", sound.layout.name, 48000)
        pieces = [one for frame in container.decode(sound) for one in packed.resample(frame)]
        samples = np.concatenate([one.to_ndarray().ravel() for one in pieces])
        heard = samples.reshape(-1, sound.layout.nb_channels)[:48000]
    spectrum = np.abs(np.fft.rfft(heard * np.hanning(len(heard))[:, None], axis=0))
    loudest = spectrum.argmax(0) * 48000 / len(heard)
    names = [one.name for one in sound.layout.channels]
    return dict(zip(names, (10 * round(one / 10) for one in loudest), strict=True))


def test_channels_without_known_places_are_dropped(tmp_path):
    src, dst = tmp_path / "in.mkv", tmp_path / "out.webm"
    with av.open(str(src), "w") as out:
        video = add_video(out)
        sound = out.add_stream("pcm_s16le", rate=48000, layout="9 channels")
        encode_frames(out, video, range(15))
        out.mux(sound.encode(sound_of(np.zeros((9600, 9)), "9 channels")))
    report = process_video(src, dst)
    assert report.dropped == ["audio #1 (pcm_s16le): webm cannot hold it"]
    assert not (report.converted or report.damaged or report.skipped_packets)


@pytest.mark.parametrize("layout", ["5.1", "5.1(side)", "quad", "4.0", "2.1", "3.0", "6.1"])
def test_any_arrangement_of_channels_goes_into_webm(tmp_path, layout):
    src, dst = tmp_path / "in.mkv", tmp_path / "out.webm"
    with av.open(str(src), "w") as out:
        video = add_video(out)
        sound = out.add_stream("flac", rate=48000, layout=layout)
        encode_frames(out, video, range(30))
        tone(out, sound, 1.0)
    report = process_video(src, dst)
    assert len(report.converted) == 1 and not report.damaged
    with av.open(str(dst)) as container:
        count = {"6.1": 8}.get(layout, av.AudioLayout(layout).nb_channels)  # see _OPUS_LAYOUTS
        assert container.streams.audio[0].layout.nb_channels == count


def test_channels_that_change_on_the_way_do_not_end_the_run(tmp_path):
    parts = []
    for second, layout in enumerate(("mono", "stereo")):
        part = tmp_path / f"{layout}.ts"
        with av.open(str(part), "w") as out:
            video, sound = add_video(out), out.add_stream("ac3", rate=48000, layout=layout)
            encode_frames(out, video, range(30 * second, 30 * second + 30))
            tone(out, sound, 1.0, start_seconds=second)
        parts.append(part.read_bytes())
    (tmp_path / "in.ts").write_bytes(b"".join(parts))
    report = process_video(tmp_path / "in.ts", tmp_path / "out.webm")
    assert report.frames_out == 60
    assert decoded_audio(tmp_path / "out.webm", "opus")[1].size == pytest.approx(96000, rel=0.1)


def decoded_audio(path, codec):
    """Return (rate in Hz, samples of the first channel, start in seconds)."""
    with av.open(str(path)) as container:
        stream = container.streams.audio[0]
        assert codec in stream.codec_context.name
        resampler = av.AudioResampler("fltp", stream.layout, stream.rate)
        frames = list(container.decode(stream))
        pieces = [p.to_ndarray()[0] for f in frames for p in resampler.resample(f)]
        begin = float(frames[0].pts * frames[0].time_base)
    return stream.rate, np.concatenate(pieces), begin


def test_a_damaged_audio_packet_is_a_gap_not_the_end(tmp_path):
    src, dst = tmp_path / "in.mkv", tmp_path / "out.webm"
    with av.open(str(src), "w") as out:
        video = add_video(out)
        sound = out.add_stream("ac3", rate=48000, layout="stereo")
        encode_frames(out, video, range(30))
        tone(out, sound, 1.0)
    data = bytearray(src.read_bytes())
    with av.open(str(src)) as container:
        packets = [bytes(packet) for packet in container.demux(audio=0) if packet.size]
    offset = data.index(packets[10])
    data[offset : offset + 200] = bytes(200)
    src.write_bytes(data)
    report = process_video(src, dst)
    assert report.frames_out == 30
    assert decoded_audio(dst, "opus")[1].size == pytest.approx(48000, abs=4800)
    assert Fraction(report.frames_out, 30) == 1


@pytest.mark.parametrize(("layout", "kbit"), [("mono", 128), ("stereo", 128), ("5.1", 384)])
def test_more_channels_get_more_bits(tmp_path, layout, kbit):
    src = tmp_path / "in.mkv"
    with av.open(str(src), "w") as out:
        tone(out, out.add_stream("flac", rate=48000, layout=layout), 0.1)
    with av.open(str(src)) as source, av.open(str(tmp_path / "out.webm"), "w") as out:
        sound = source.streams.audio[0]
        converter = AudioConverter(out, sound, "libopus", sound.codec_context)
        assert converter.stream.codec_context.bit_rate == 1000 * kbit
