"""Sources of sound: a file that plays as the camera, and a microphone."""

import itertools
import subprocess
import sys
import time
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import av
import numpy as np
import pytest
from claps import clap_clip, marks
from makeup_video.pipeline import InputError
from makeup_video.pipeline.live.interfaces import LivePicture
from makeup_video.pipeline.live.sinks.recording import Recording
from makeup_video.pipeline.live.sound import RATE, LiveSound
from makeup_video.pipeline.live.sources import file_sound, microphone
from makeup_video.pipeline.live.sources.camera import CameraSettings, open_source
from makeup_video.pipeline.live.sources.file_sound import FileSound
from makeup_video.pipeline.live.sources.microphone import Microphone, microphones_found
from media import make_clip


def recorded(clip, path, *, loop=False, seconds=60.0):
    camera = open_source(CameraSettings(name=str(clip), loop=loop), pytest.fail)
    sound = LiveSound(camera.file_sound(), pytest.fail)
    recording = Recording(path, sound=sound.tap())
    sound.start()
    until = time.monotonic() + seconds
    for frame in camera.frames():
        recording(LivePicture(frame))
        if time.monotonic() > until:
            camera.close()
    recording.finish()
    sound.close()
    return recording


@pytest.mark.parametrize("end", ["mkv", "mp4", "webm"])
def test_flash_and_clap_of_a_video_stay_together(tmp_path, end):
    clip, path = clap_clip(tmp_path / "clap.mp4", 3), tmp_path / f"out.{end}"
    recording = recorded(clip, path)
    flashes, claps = marks(path)
    assert len(flashes) == len(claps) == 2
    assert np.abs(np.subtract(flashes, claps)).max() < 0.020
    assert recording.state.endswith("s, with audio from clap.mp4")


def test_further_passes_are_in_step_too(tmp_path):
    clip = clap_clip(tmp_path / "clap.mp4", 2, sound_seconds=1.7)
    recorded(clip, tmp_path / "out.mkv", loop=True, seconds=5.2)
    flashes, claps = marks(tmp_path / "out.mkv")
    assert len(flashes) >= 2
    for flash in flashes[:-1]:  # the run may end between the last flash and its clap
        assert min(abs(clap - flash) for clap in claps) < 0.020


def test_sound_that_is_asked_for_late_begins_with_the_present(tmp_path):
    clip = clap_clip(tmp_path / "clap.mp4", 30)
    playing = SimpleNamespace(turn=1, zero_seconds=time.monotonic() - 20)
    sound = FileSound(clip, playing)
    blocks = list(itertools.islice(sound.blocks(), 150))
    begins = [block.begins_seconds - playing.zero_seconds for block in blocks]
    assert begins[0] > 18 and begins[-1] > 20
    loud = [at for at, block in zip(begins, blocks, strict=True) if abs(block.samples).max() > 0.3]
    assert min(abs(at - 20) for at in loud) < 0.05  # the clap at 20 s


def test_a_file_that_cannot_seek_plays_its_sound_on(tmp_path, monkeypatch):
    clip = clap_clip(tmp_path / "clap.mp4", 4)
    monkeypatch.setattr(file_sound, "open_container", lambda path: NoSeek(av.open(str(path))))
    sound = FileSound(clip, SimpleNamespace(turn=1, zero_seconds=time.monotonic() - 2.5))
    asked = time.monotonic()
    assert next(sound.blocks()).begins_seconds > asked - 1.001


class NoSeek:
    """A container whose file cannot seek."""

    def __init__(self, container):
        self._container = container

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._container.close()

    def __getattr__(self, name):
        return getattr(self._container, name)

    def seek(self, offset):
        raise av.PermissionError(1, "cannot seek")


def test_a_video_without_sound_gives_none(tmp_path):
    camera = open_source(
        CameraSettings(name=str(make_clip(tmp_path / "in.mp4", frames=3))), pytest.fail
    )
    assert camera.file_sound() is None
    camera.close()


def test_sound_that_a_file_announces_but_lacks_is_none(tmp_path):
    path = tmp_path / "in.ts"
    with av.open(str(path), "w", format="mpegts") as container:
        video = container.add_stream("libx264", rate=25)
        video.width, video.height, video.pix_fmt = 64, 64, "yuv420p"
        container.add_stream("aac", rate=48000)
        for pts in range(10):
            picture = av.VideoFrame(64, 64, "yuv420p")
            picture.pts, picture.time_base = pts, Fraction(1, 25)
            container.mux(video.encode(picture))
        container.mux(video.encode(None))
    with av.open(str(path)) as container:
        assert len(container.streams.audio) == 1
    camera = open_source(CameraSettings(name=str(path)), pytest.fail)
    assert camera.file_sound() is None
    camera.close()


def test_whatever_ends_the_sound_the_video_goes_on():
    class Odd:
        name, channels = "odd", 1

        def blocks(self):
            raise KeyError(0)
            yield

        def close(self):
            pass

    lines = []
    sound = LiveSound(Odd(), lines.append)
    sound.start()
    sound._thread.join(10)
    assert lines == ["odd cannot be heard (KeyError: 0); the video continues without audio"]


ALSA = """
import os, sys
os.environ["ALSA_CONFIG_PATH"] = sys.argv[1]
from makeup_video.pipeline.live.sources.microphone import Microphone
heard = Microphone("mic", print)
assert heard.channels == 2
count = loudest = 0
for block in heard.blocks():
    assert block.samples.shape[0] == 2 and block.samples.dtype == "float32"
    count += block.samples.shape[1]
    loudest = max(loudest, float(block.samples[0].max()))
    if count > 4800:
        heard.close()
print(heard.name, round(loudest, 2))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="ALSA is Linux's")
def test_an_alsa_device_is_read(tmp_path):
    """A file stands in for the microphone, behind ALSA's own interface."""
    tone = (0.5 * 32767 * np.sin(np.arange(RATE) * 0.05)).astype("<i2")
    np.stack([tone, tone], axis=1).tofile(tmp_path / "tone.raw")
    (tmp_path / "conf").write_text(
        'pcm.mic { type file slave.pcm { type null } file "/dev/null" '
        f'infile "{tmp_path}/tone.raw" format raw }}'
    )
    done = subprocess.run(
        [sys.executable, "-c", ALSA, str(tmp_path / "conf")],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout == "mic 0.5\n"


def test_microphones_are_those_that_the_kernel_lists(tmp_path, monkeypatch):
    listed = tmp_path / "pcm"
    listed.write_text(
        "00-00: ALC257 Analog : ALC257 Analog : playback 1 : capture 1\n"
        "00-03: HDMI 0 : HDMI 0 : playback 1\n"
        "01-00: USB Audio : USB Audio : capture 1\n"
    )
    monkeypatch.setattr(microphone, "_system", lambda: "alsa")
    monkeypatch.setattr(microphone, "_ALSA_DEVICES", listed)
    names = [name for name, _ in microphones_found()]
    assert names == ["default", "plughw:0,0", "plughw:1,0"]
    monkeypatch.setattr(microphone, "_ALSA_DEVICES", Path(tmp_path / "none"))
    assert microphones_found() == []


def test_a_microphone_without_sound_yet_is_not_gone(monkeypatch):
    """macOS raises this error while no sound waits."""
    times = []

    class Quiet:
        streams = SimpleNamespace(
            audio=[SimpleNamespace(codec_context=SimpleNamespace(channels=1))]
        )

        def demux(self, audio):
            times.append(audio)
            if len(times) < 4:
                raise av.BlockingIOError(11, "Resource temporarily unavailable")
            heard.close()
            yield from ()

        def close(self):
            pass

    monkeypatch.setattr(microphone, "_open", lambda name: Quiet())
    heard = Microphone("built in", pytest.fail)
    assert list(heard.blocks()) == [] and len(times) == 4


def test_a_microphone_that_is_not_there_is_one_line(monkeypatch):
    monkeypatch.setattr(microphone, "_system", lambda: "alsa")
    with pytest.raises(
        InputError, match=r"the microphone nobody cannot be opened \(.*found: "
    ) as caught:
        Microphone("nobody", pytest.fail)
    assert "\n" not in str(caught.value)
