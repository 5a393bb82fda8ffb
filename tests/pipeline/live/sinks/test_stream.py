"""Streams: the received video, absent receivers, and secrets that no message shows."""

import contextlib
import os
import socket
import stat
import threading
import time

import av
import numpy as np
import pytest
from makeup_video.pipeline import EncodeError, InstallError, OutputError, UsageError
from makeup_video.pipeline.live.interfaces import LivePicture
from makeup_video.pipeline.live.sinks import srt_relay
from makeup_video.pipeline.live.sinks import stream as live_stream
from makeup_video.pipeline.live.sinks.stream import Stream, bit_rate_for
from makeup_video.pipeline.live.sound import RATE, SoundBlock, SoundTap
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera
from media import picture

SECRET = "s3cr3t-key"


def live(milliseconds, size_wh=(96, 64), degrees=0):
    door = NormaliseCamera(is_device=True)
    for index, milliseconds_in in enumerate(milliseconds):
        frame = door(picture(index, *size_wh, "yuvj422p"), 55555.123 + milliseconds_in / 1000)
        frame.rotation_degrees = degrees
        yield LivePicture(frame)


def free_port(kind=socket.SOCK_DGRAM):
    with socket.socket(socket.AF_INET, kind) as udp_socket:
        udp_socket.bind(("127.0.0.1", 0))
        return udp_socket.getsockname()[1]


@pytest.fixture
def pieces(monkeypatch, tmp_path):
    """Files that receive the stream instead of the network, one per connection."""
    paths = []

    def container(url, format_name, relay):
        paths.append(tmp_path / f"{len(paths)}.{format_name}")
        return av.open(str(paths[-1]), "w", format=format_name)

    monkeypatch.setattr(live_stream, "_container", container)
    return paths


@pytest.mark.parametrize("scheme", ["udp", "rtmp"])
def test_pictures_keep_their_times_with_regular_key_frames(pieces, scheme):
    stream = Stream(f"{scheme}://host/live/{SECRET}", log=pytest.fail)
    times = [0, 40, 100, 1000, 1990, 2010, 2050, 4020, 4060]
    for live_picture in live(times):
        stream(live_picture)
    stream.finish()
    with av.open(str(pieces[0])) as got:
        packets = [p for p in got.demux(video=0) if p.size]
        seconds = np.array([float(p.pts * p.time_base) for p in packets])
        video = got.streams.video[0].codec_context
        assert (video.width, video.height, video.color_range) == (96, 64, 2)
    assert np.round((seconds - seconds[0]) * 1000).tolist() == times
    assert [p.is_keyframe for p in packets] == [
        milliseconds in (0, 2010, 4020) for milliseconds in times
    ]


@pytest.mark.parametrize("scheme", ["udp", "rtmp"])
def test_the_sound_is_sent_in_step_with_the_pictures(pieces, scheme):
    tap = SoundTap("card", 1)
    stream = Stream(f"{scheme}://host/live", log=pytest.fail, sound=tap)
    sound = np.zeros((1, RATE * 3), np.float32)
    sound[0, RATE * 2 :][:480] = 0.8 * np.sin(np.arange(480) * 0.5)  # two seconds after the start
    for number, live_picture in enumerate(live(range(0, 2900, 100))):
        stream(live_picture)
        part = sound[:, number * 4800 : (number + 1) * 4800]
        tap.put(SoundBlock(part, 55555.123 + number / 10))
    assert stream.state == ", with audio from card"
    stream.finish()
    with av.open(str(pieces[0])) as got:
        first = min(float(p.pts * p.time_base) for p in got.demux(video=0) if p.size)
    with av.open(str(pieces[0])) as got:
        claps = [
            frame.time + at / RATE
            for frame in got.decode(audio=0)
            for at in np.flatnonzero(np.abs(frame.to_ndarray()[0]) > 0.3)
        ]
    assert claps[0] - first == pytest.approx(2.0, abs=0.020)


def test_the_pictures_are_only_read(pieces):
    stream, pictures = Stream("udp://host:1", log=pytest.fail), list(live([0, 2500]))
    for live_picture in pictures:
        stream(live_picture)
    assert [live_picture.frame.picture.pict_type for live_picture in pictures] == [0, 0]
    assert [live_picture.frame.picture.pts for live_picture in pictures] == [
        live_picture.frame.pts for live_picture in pictures
    ]


def test_formats_without_rotation_get_upright_pictures(pieces):
    stream = Stream("udp://host:1", log=pytest.fail)
    for live_picture in live(range(0, 800, 40), degrees=90):
        stream(live_picture)
    stream.finish()
    with av.open(str(pieces[0])) as got:
        assert next(got.decode(video=0)).width == 64


def test_a_receiver_over_udp_gets_a_video(tmp_path):
    port, got = free_port(), []

    def receive():
        with av.open(f"udp://127.0.0.1:{port}?timeout=20000000", format="mpegts") as received:
            for frame in received.decode(video=0):
                got.append(frame)
                if len(got) == 20:
                    return

    receiver = threading.Thread(target=receive)
    receiver.start()
    stream = Stream(f"udp://127.0.0.1:{port}", log=lambda line: None)
    for live_picture in live(range(0, 400_000, 33)):
        stream(live_picture)
        receiver.join(0.005)
        if not receiver.is_alive():
            break
    stream.finish()
    receiver.join(30)
    assert len(got) == 20 and (got[0].width, got[0].height) == (96, 64)
    assert stream.name == "udp://127.0.0.1"


class Gone:
    """A container whose receiver disconnects after some packets."""

    def __init__(self, packets):
        self.left, self.inner = packets, av.open(os.devnull, "w", format="mpegts")

    def __getattr__(self, name):
        return getattr(self.inner, name)

    def mux_one(self, packet):
        self.left -= 1
        if self.left < 0:
            raise av.error.BrokenPipeError(32, "Broken pipe", f"rtmp://host/{SECRET}")
        self.inner.mux_one(packet)


def test_a_lost_receiver_is_logged_and_retried_ever_slower(monkeypatch):
    clock, tries, lines = [1000.0], [], []
    refused = av.error.ConnectionRefusedError(111, "refused", f"rtmp://host/{SECRET}")

    def container(url, format_name, relay):
        tries.append(clock[0])
        if len(tries) == 1:
            return Gone(3)
        if len(tries) < 8:
            raise refused
        return Gone(10**6)

    monkeypatch.setattr(live_stream, "_container", container)
    monkeypatch.setattr(live_stream.time, "monotonic", lambda: clock[0])
    stream = Stream(f"rtmp://user:{SECRET}@host/live/{SECRET}", log=lines.append)
    for live_picture in live(range(0, 150_000, 100)):
        clock[0] += 0.1
        stream(live_picture)
    stream.finish()
    pauses = np.diff(tries)
    assert pauses == pytest.approx([1.4, 2, 4, 8, 16, 30, 30], abs=0.21)
    assert lines == [
        "rtmp://host: Broken pipe; trying again",
        "rtmp://host: sending",
    ]
    assert stream.notice == ""
    at_last = sum(1 for tick in range(1, 1501) if 1000 + 0.1 * tick > tries[7] - 0.05)
    assert stream.sent == 3 + at_last  # three before the break, the others after the last try


@pytest.fixture
def slammed():
    """The port of a server that accepts each connection and closes it at once."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def slam():
            with contextlib.suppress(OSError):  # the fixture closes the server
                while True:
                    server.accept()[0].close()

        threading.Thread(target=slam, daemon=True).start()
        yield server.getsockname()[1]


@pytest.mark.parametrize("closed", [True, False])
def test_a_stream_that_never_connected_is_an_error_at_the_end(slammed, closed):
    port = free_port(socket.SOCK_STREAM) if closed else slammed
    lines = []
    stream = Stream(f"rtmp://127.0.0.1:{port}/live/{SECRET}", log=lines.append)
    for live_picture in live(range(0, 400, 40)):
        stream(live_picture)
    assert stream.sent == 0 and len(lines) == 1
    with pytest.raises(
        OutputError, match=r"^rtmp://127.0.0.1: .*; no frame was sent in the"
    ) as caught:
        stream.finish()
    assert SECRET not in str(caught.value) and "\n" not in str(caught.value)


def test_a_run_without_any_picture_is_no_error_of_the_stream():
    stream = Stream("rtmp://127.0.0.1:1/live", log=pytest.fail)
    stream.finish()
    assert stream.sent == 0


def test_an_absent_receiver_is_one_line_without_the_key(capfd):
    lines = []
    port = free_port(socket.SOCK_STREAM)
    stream = Stream(f"rtmp://user:{SECRET}@127.0.0.1:{port}/live/{SECRET}", log=lines.append)
    for live_picture in live([0, 40, 80]):
        stream(live_picture)
    assert lines == ["rtmp://127.0.0.1: Connection refused; trying again"]
    assert stream.notice == lines[0]
    assert SECRET not in "".join([*capfd.readouterr(), *lines, stream.name])


@pytest.mark.parametrize(
    "url",
    [
        f"http://user:{SECRET}@host/{SECRET}",
        f"file:///{SECRET}",
        f"rtmp:///{SECRET}",
        f"rtmp://host/a {SECRET}",
        f"{SECRET}",
        f"concat:{SECRET}|b",
        f"rtmp://[{SECRET}",
        "",
    ],
)
def test_other_addresses_are_refused_without_showing_them(url):
    with pytest.raises(UsageError) as caught:
        Stream(url, log=pytest.fail)
    assert SECRET not in str(caught.value) and "\n" not in str(caught.value)


def test_the_name_is_scheme_and_host_only():
    def name(url):
        return Stream(url, log=pytest.fail).name

    assert (
        name(f"rtmps://u:{SECRET}@Host.example:443/app/{SECRET}?{SECRET}") == "rtmps://host.example"
    )
    assert name("udp://[::1]:5000") == "udp://[::1]"


FFMPEG = """#!/bin/sh
case "$*" in *-protocols*) echo "file srt udp"; exit;; esac
for last; do :; done
printf '%s' "$last" > "$0.url"
exec cat > "$0.ts"
"""


@pytest.fixture
def program(tmp_path, monkeypatch):
    """An `ffmpeg` on the PATH that supports SRT, and stores its input."""
    path = tmp_path / "ffmpeg"
    path.write_text(FFMPEG)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    return path


def test_srt_goes_through_an_ffmpeg_that_knows_it(program):
    url = f"srt://127.0.0.1:1?passphrase={SECRET}"
    stream = Stream(url, log=pytest.fail)
    for live_picture in live(range(0, 1000, 40)):
        stream(live_picture)
    assert stream.sent == 0  # the relay accepts everything, even while it is not connected
    stream.finish()
    assert stream.sent == 25  # the relay exited without an error
    assert program.with_suffix(".url").read_text() == url
    with av.open(str(program.with_suffix(".ts"))) as got:
        assert len(list(got.decode(video=0))) == 25


def test_a_failing_encoder_ends_the_stream_and_its_relay(program, monkeypatch):
    def refuse(self, picture):
        raise EncodeError("no")

    stream = Stream("srt://127.0.0.1:1", log=pytest.fail)
    first, second = live([0, 40])
    stream(first)
    relay = stream._connection._relay._process
    monkeypatch.setattr(live_stream.LiveEncoder, "__call__", refuse)
    with pytest.raises(EncodeError):
        stream(second)
    assert relay.poll() is not None


def test_a_relay_that_ends_counts_as_a_lost_receiver(program):
    program.write_text(FFMPEG.replace('exec cat > "$0.ts"', "exit 1"))
    lines = []
    stream = Stream("srt://127.0.0.1:1", log=lines.append)
    deadline = time.monotonic() + 30
    for live_picture in live(range(0, 400_000, 33), size_wh=(320, 240)):
        stream(live_picture)
        if lines or time.monotonic() > deadline:
            break
    with pytest.raises(OutputError, match="Broken pipe; no frame was sent"):
        stream.finish()
    assert stream.sent == 0
    assert lines == ["srt://127.0.0.1: Broken pipe; trying again"]


def test_a_relay_that_never_connected_has_sent_nothing(program):
    program.write_text(FFMPEG.replace('exec cat > "$0.ts"', "cat > /dev/null; exit 1"))
    stream = Stream("srt://127.0.0.1:1", log=pytest.fail)
    for live_picture in live([0, 40]):
        stream(live_picture)
    with pytest.raises(OutputError, match=r"srt://127.0.0.1: no connection; no frame was sent"):
        stream.finish()
    assert stream.sent == 0


def test_srt_without_a_program_for_it_is_refused_with_advice(monkeypatch):
    monkeypatch.setattr(srt_relay.shutil, "which", lambda name: None)
    with pytest.raises(InstallError, match=r"srt://host needs an ffmpeg with SRT on the PATH"):
        Stream(f"srt://host:1?passphrase={SECRET}", log=pytest.fail)


def test_larger_pictures_get_more_bits_but_fewer_a_pixel():
    pixels = [640 * 360, 1280 * 720, 1920 * 1080, 3840 * 2160]
    rates = [bit_rate_for(n) for n in pixels]
    assert rates == sorted(rates) and rates[1] == 3_000_000
    per_pixel = [rate / n for rate, n in zip(rates, pixels, strict=True)]
    assert per_pixel == sorted(per_pixel, reverse=True)
