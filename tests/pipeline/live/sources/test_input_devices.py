"""Cameras and microphones, read from FFmpeg's lists."""

from types import SimpleNamespace

import av
import pytest
from makeup_video.pipeline.live.sources import input_devices as listed
from makeup_video.pipeline.live.sources.input_devices import input_devices


@pytest.mark.parametrize("kind", ["video", "audio"])
def test_only_devices_of_the_kind_are_listed(kind, monkeypatch):
    found = [SimpleNamespace(name=one, media_types=[one]) for one in ("audio", "video")]
    monkeypatch.setattr(listed, "enumerate_input_devices", lambda system: found)
    assert [device.name for device in input_devices("dshow", kind)] == [kind]


@pytest.mark.parametrize("error", [NotImplementedError, ValueError, av.FFmpegError(1, "no")])
def test_a_system_that_cannot_list_devices_has_none(error, monkeypatch):
    def refuse(system):
        raise error

    monkeypatch.setattr(listed, "enumerate_input_devices", refuse)
    assert input_devices("dshow", "video") == []


def test_an_interface_that_ffmpeg_lacks_has_none():
    assert input_devices("no such interface", "audio") == []
