"""Fake cameras: their pictures, their faults, and their loss and return."""

import threading
import time

import av
import pytest
from cameras import Damaged, FakeDevice, Scripted, mjpeg, raw_yuyv, unplugged
from makeup_video.pipeline import DecodeError, InputError
from makeup_video.pipeline.live.sources import device
from makeup_video.pipeline.live.sources.camera import CameraSettings, open_source
from makeup_video.pipeline.live.sources.device import attempts
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera


class Endless(FakeDevice):
    """A camera whose JPEGs lack the end marker."""

    def changed(self, packet):
        data = bytes(packet)
        return av.Packet(data[: data.rfind(b"\xff\xd9")])


def test_mjpeg_is_tried_before_raw_pixels_and_then_anything():
    wish = device.CameraRequest("1280x720", 30, None)
    tried = attempts(wish, "v4l2")
    assert [opened.get("input_format") for opened in tried] == [
        "mjpeg",
        "yuyv422",
        None,
        None,
        None,
    ]
    assert tried[0]["video_size"] == "1280x720" and set(tried[-1]) == {"fflags"}
    raw = attempts(device.CameraRequest(None, None, "yuyv422"), "v4l2")
    assert [opened.get("input_format") for opened in raw] == ["yuyv422", "mjpeg", None]
    assert attempts(wish, "dshow")[0]["vcodec"] == "mjpeg"
    assert attempts(wish, "avfoundation")[0]["framerate"] == "30"


@pytest.fixture
def plug(monkeypatch):
    """plug(device, ...): the results of opening the camera, in order; exceptions are raised."""
    monkeypatch.setattr(device, "_RETRY_SECONDS", 0.01)
    opened = []

    def setup(*devices):
        rest = list(devices)

        def open_camera(name, system, options):
            opened.append((name, options))
            result = rest.pop(0) if rest else OSError(19, "No such device")
            if isinstance(result, Exception):
                raise result
            return result

        monkeypatch.setattr(device, "open_camera", open_camera)
        return opened

    return setup


def settings(**more):
    return CameraSettings(**{"name": "/dev/video0", "size": None, "rate": None, **more})


def test_only_the_newest_picture_is_given_and_others_counted(tmp_path, plug):
    begin, ended, stay = threading.Event(), threading.Event(), threading.Event()
    plug(FakeDevice(mjpeg(tmp_path, frames=6), lambda: (ended.set(), stay.wait()), begin))
    camera = open_source(settings(), lambda line: None)
    frames = camera.frames()
    begin.set()
    assert ended.wait(20)
    first = next(frames)
    assert camera.dropped == 5 and first.seconds <= time.monotonic()
    stay.set()
    camera.close()
    assert next(frames, None) is None


def test_a_picture_from_before_the_first_request_is_kept(tmp_path, plug):
    ended, stay = threading.Event(), threading.Event()
    plug(FakeDevice(mjpeg(tmp_path, frames=6), lambda: (ended.set(), stay.wait())))
    camera = open_source(settings(), lambda line: None)
    assert ended.wait(20)  # for instance, while the nets load
    next(camera.frames())
    stay.set()
    camera.close()
    assert camera.dropped == 0


def test_a_camera_that_gives_no_picture_is_logged_once(tmp_path, plug):
    lines, opened = [], []
    path = mjpeg(tmp_path)

    class Dumb(FakeDevice):
        def demux(self, video):
            opened.append(self)
            if len(opened) == 5:
                threading.Thread(target=camera.close).start()
            unplugged()

    plug(*(Dumb(path, unplugged) for _ in range(6)))
    camera = open_source(settings(), lines.append)
    assert list(camera.frames()) == [] and len(opened) >= 5
    assert lines == ["camera /dev/video0 is gone: waiting for it"]


def test_a_cameras_loss_and_return_are_each_logged_once(tmp_path, plug):
    lines, back = [], threading.Event()
    gone = OSError(19, "No such device")
    second = FakeDevice(mjpeg(tmp_path, "b.avi", size_wh=(128, 48)), back.wait)
    plug(FakeDevice(mjpeg(tmp_path), unplugged), gone, gone, second)
    camera = open_source(settings(), lines.append)
    got = []
    for frame in camera.frames():
        got.append(frame)
        if len(lines) == 2:
            back.set()
            camera.close()
    assert lines == [
        "camera /dev/video0 is gone: waiting for it",
        "camera /dev/video0 is back",
    ]
    assert camera.notice == ""
    assert {(f.width_px, f.height_px) for f in got} <= {(64, 48)}
    pts = [f.pts for f in got]
    assert pts == sorted(set(pts)) and abs(got[-1].seconds - time.monotonic()) < 60


def test_close_ends_the_wait_for_a_camera_that_is_gone(tmp_path, plug):
    lines = []

    def log(line):
        lines.append(line)
        threading.Timer(0.05, camera.close).start()  # by then the camera usually waits

    begin = threading.Event()
    plug(FakeDevice(mjpeg(tmp_path), unplugged, begin))
    camera = open_source(settings(), log)
    begin.set()
    list(camera.frames())  # must return
    assert lines == ["camera /dev/video0 is gone: waiting for it"]


def test_a_hanging_camera_is_logged_and_close_does_not_wait(tmp_path, plug, monkeypatch):
    monkeypatch.setattr(device, "_SILENT_SECONDS", 0.05)
    lines, ended, hanging = [], threading.Event(), threading.Event()
    plug(FakeDevice(mjpeg(tmp_path), lambda: (ended.set(), hanging.wait())))

    def log(line):
        lines.append(line)
        threading.Timer(0.05, camera.close).start()

    camera = open_source(settings(), log)
    assert ended.wait(20)
    list(camera.frames())
    hanging.set()
    assert lines == ["camera /dev/video0 sends no frames: waiting for it"]
    assert camera.notice == lines[0]


def test_a_camera_whose_pictures_cannot_be_used_ends_the_run(tmp_path, plug, monkeypatch):
    def refuse(self, picture):
        raise DecodeError("no")

    monkeypatch.setattr(NormaliseCamera, "_converted", refuse)
    plug(FakeDevice(mjpeg(tmp_path), unplugged))
    camera = open_source(settings(), pytest.fail)
    with pytest.raises(DecodeError, match="no"):
        next(camera.frames())


def test_damaged_jpegs_are_counted_and_skipped(tmp_path, plug):
    begin, ended, stay = threading.Event(), threading.Event(), threading.Event()
    plug(Damaged(mjpeg(tmp_path, frames=8), lambda: (ended.set(), stay.wait()), begin))
    camera = open_source(settings(), lambda line: None)
    frames = camera.frames()
    begin.set()
    assert ended.wait(20)
    assert camera.damaged == 3 and camera.dropped == 4  # of five good frames, only the newest waits
    frame = next(frames)
    assert (frame.pix_fmt, frame.tags.range) == ("yuv420p", 2)
    stay.set()
    camera.close()


def test_a_camera_in_place_of_another_may_omit_end_markers(tmp_path, plug, monkeypatch):
    monkeypatch.setattr(device, "cameras_found", lambda: ["/dev/video0"])
    stay = threading.Event()
    plug(FakeDevice(mjpeg(tmp_path), unplugged), Endless(mjpeg(tmp_path, "b.avi"), stay.wait))
    back = threading.Event()
    camera = open_source(settings(name=None), lambda line: "back" in line and back.set())
    camera.frames()
    assert back.wait(20) and camera.damaged == 0
    stay.set()
    camera.close()


def test_settings_that_a_camera_changes_are_one_logged_line(tmp_path, plug):
    lines, stay = [], threading.Event()
    no = av.error.ArgumentError(22, "Invalid argument")
    opened = plug(no, FakeDevice(raw_yuyv(tmp_path / "cam.avi"), stay.wait))
    camera = open_source(settings(size="1280x720", rate=30, pixels="mjpeg"), lines.append)
    frame = next(camera.frames())
    stay.set()
    camera.close()
    assert [options.get("input_format") for _, options in opened] == ["mjpeg", "yuyv422"]
    assert lines == [
        "camera /dev/video0 gives 64x48, not 1280x720; 10 frames a second, not 30; yuyv422, not mjpeg"
    ]
    assert (frame.tags.matrix, frame.tags.range, camera.rate) == (6, 1, 10)
    assert camera.size == "64x48"  # what a page shows
    assert frame.picture.format.name == "yuv420p"


@pytest.mark.parametrize(
    ("number", "advice"), [(13, "group video"), (16, "another program uses it")]
)
def test_a_camera_without_permission_is_refused_with_advice(plug, number, advice):
    opened = plug(OSError(number, "no"))
    with pytest.raises(InputError, match=advice) as caught:
        open_source(settings(), pytest.fail)
    assert "\n" not in str(caught.value) and len(opened) == 1


def test_pictures_queued_in_the_driver_by_a_stall_are_dropped(tmp_path, plug, monkeypatch):
    clock, shown = [0.0], []
    begin, ended, stay = threading.Event(), threading.Event(), threading.Event()
    monkeypatch.setattr(device.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(
        device.DeviceCamera, "_offer", lambda self, frame: shown.append(frame.seconds)
    )
    fresh = [(0.50, 0.50), (0.53, 0.53)]
    stalled = [(0.56, 1.56), (0.60, 1.56), (0.63, 1.56)]  # the stall hit the read of the first
    script = [*fresh, *stalled, (1.60, 1.60)]
    plug(Scripted(mjpeg(tmp_path), lambda: (ended.set(), stay.wait()), begin, clock, script))
    camera = open_source(settings(), lambda line: None)
    camera.frames()
    begin.set()
    assert ended.wait(20)
    stay.set()
    camera.close()
    assert shown == pytest.approx([0.50, 0.53, 1.60]) and camera.dropped == 3
