"""A live run whose camera is exchanged for another."""

import os
import threading
from types import SimpleNamespace

import pytest
from makeup_video.pipeline import MakeupVideoError
from makeup_video.pipeline.live.sources import switch as switch_module
from makeup_video.pipeline.live.sources.camera import CameraSettings
from makeup_video.pipeline.live.sources.switch import CameraSwitch
from media import make_clip


@pytest.fixture
def clips(tmp_path):
    sizes = {"a": (64, 48), "b": (96, 64)}
    return {
        name: str(make_clip(tmp_path / f"{name}.mp4", frames=9, width=w, height=h))
        for name, (w, h) in sizes.items()
    }


def frames_of(switch, wanted, on_frame=lambda count: None):
    """The widths of all frames up to the first of the wanted width, or the end of the source."""
    widths, times = [], []
    for frame in switch.frames():
        widths.append(frame.width_px)
        times.append(frame.pts)
        on_frame(len(widths))
        if widths[-1] == wanted:
            switch.close()
    assert times == sorted(set(times))
    return widths


def test_frames_of_another_camera_follow_with_later_times(clips):
    switch = CameraSwitch(CameraSettings(name=clips["a"], loop=True), pytest.fail)

    def on_frame(count):
        if count == 3:
            threading.Thread(target=switch.choose, args=(clips["b"], "64x64")).start()

    widths = frames_of(switch, 96, on_frame)
    assert widths[:3] == [64, 64, 64] and widths[-1] == 96
    assert switch.choices()["name"] == clips["b"]
    assert clips["a"] in switch.choices()["names"]  # one can switch back
    assert switch.choices()["size"] is None


def test_another_camera_is_asked_for_the_size_of_the_run(clips, monkeypatch):
    asked = []

    def open_source(settings, log):
        asked.append((settings.name, settings.size))
        return opened(settings, log)

    opened = switch_module.open_source
    monkeypatch.setattr(switch_module, "open_source", open_source)
    switch = CameraSwitch(CameraSettings(name=clips["a"], size="1920x1080"), pytest.fail)
    for name, size in (("b", ""), ("a", "640x480"), ("b", "")):
        switch.choose(clips[name], size)
    assert [size for _, size in asked] == ["1920x1080", "1920x1080", "640x480", "640x480"]
    switch.close()


@pytest.mark.parametrize(
    ("name", "size"), [("/nowhere/x.mp4", "64x64"), ("", "64x64"), ("a", "big")]
)
def test_a_camera_that_does_not_open_leaves_the_old_one(clips, name, size):
    switch = CameraSwitch(CameraSettings(name=clips["a"], loop=True), pytest.fail)
    refused = []

    def choose():
        try:
            switch.choose(clips.get(name, name), size)
        except MakeupVideoError as error:
            refused.append(str(error))

    def on_frame(count):
        if count == 2:
            threading.Thread(target=choose).start()
        if refused and count > 12:
            switch.close()

    widths = frames_of(switch, None, on_frame)
    assert set(widths) == {64} and len(refused) == 1 and "\n" not in refused[0]


def test_a_camera_that_is_gone_for_a_while_comes_back(clips, tmp_path, monkeypatch):
    monkeypatch.setattr(switch_module, "_RETRY_SECONDS", 0.01)
    seen, lines = [], []
    switch = CameraSwitch(CameraSettings(name=clips["a"], loop=True), lines.append)

    def choose():
        os.rename(clips["a"], tmp_path / "hidden")
        with pytest.raises(MakeupVideoError):
            switch.choose("/nowhere/x.mp4", "64x64")
        lines.append(switch.notice)
        seen.append("gone")
        os.rename(tmp_path / "hidden", clips["a"])

    def on_frame(count):
        if count == 2:
            threading.Thread(target=choose).start()
        if seen:
            seen.append("frame")
        if len(seen) > 30:
            switch.close()

    assert set(frames_of(switch, None, on_frame)) == {64}
    assert seen[0] == "gone" and len(seen) > 30
    name = switch.name
    notice = f"camera {name} cannot be opened now: waiting for it"
    assert lines == [notice, notice, f"camera {name} is open again"]
    assert switch.notice == ""


def test_a_choice_that_waits_for_another_counts_as_a_change(monkeypatch):
    """Otherwise `frames` would think that the camera which the choice closes had ended."""
    changing, waits, threads, lock = {}, threading.Event(), {}, threading.Lock()

    class Opening:
        def __enter__(self):
            if threading.current_thread() is threads["b"]:
                waits.set()
                threads["a"].join()
            lock.acquire()

        def __exit__(self, *_):
            lock.release()

    def open_source(settings, log):
        if settings.name == "a":
            threads["b"].start()
            assert waits.wait(60)

        def close():
            changing[settings.name] = switch._is_switching

        return SimpleNamespace(name=settings.name, path=None, dropped=0, damaged=0, close=close)

    monkeypatch.setattr(switch_module, "Lock", Opening)
    monkeypatch.setattr(switch_module, "open_source", open_source)
    switch = CameraSwitch(CameraSettings(name="first"), pytest.fail)
    for name in ("a", "b"):
        threads[name] = threading.Thread(target=switch.choose, args=(name, "64x64"))
    threads["a"].start()
    for name in ("a", "b"):
        threads[name].join()
    assert changing == {"first": True, "a": True} and switch.name == "b"


def test_a_video_that_ends_ends_the_run(clips):
    switch = CameraSwitch(CameraSettings(name=clips["a"]), pytest.fail)
    assert len(frames_of(switch, None)) == 9
