"""The source of a live run: files played in real time, and cameras, faked where a device is opened."""

import itertools
import threading
import time
from contextlib import closing
from fractions import Fraction

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import DecodeError, InputError, UsageError
from makeup_video.pipeline.frames.frame import plane_views
from makeup_video.pipeline.frames.transform import upright
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE
from makeup_video.pipeline.live.sources import device as camera_device
from makeup_video.pipeline.live.sources import file as camera_file
from makeup_video.pipeline.live.sources.camera import Camera, CameraSettings
from makeup_video.pipeline.live.sources.device import attempts
from makeup_video.pipeline.live.sources.file import Timeline
from makeup_video.pipeline.live.sources.freshness import Freshness
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera
from media import damage, make_clip, picture

# -- what the door makes of pictures -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("pix_fmt", "matrix", "span"),
    [("yuvj422p", 5, 2), ("yuvj420p", 5, 2), ("yuyv422", 6, 1), ("nv12", 6, 1), ("uyvy422", 6, 1)],
)
def test_a_camera_s_picture_is_420_with_its_own_numbers_and_true_tags(pix_fmt, matrix, span):
    shown = picture(3, 64, 48, pix_fmt)
    luma = shown.reformat(format="yuvj422p" if span == 2 else "yuv422p", src_color_range=span,
                          dst_color_range=span)  # fmt: skip
    shown.color_range = 2 if span == 2 else 0
    shown.colorspace = 5 if span == 2 else 2  # as FFmpeg's decoders say it
    frame = NormaliseCamera(is_device=True)(shown, 12.5)
    assert (frame.pix_fmt, frame.tags.matrix, frame.tags.range) == ("yuv420p", matrix, span)
    assert (frame.tags.primaries, frame.tags.transfer) == (1, 1)
    np.testing.assert_array_equal(frame.planes[0], plane_views(luma, 8)[0])
    assert (frame.pts, frame.time_base) == (12_500_000, LIVE_TIME_BASE)
    assert (frame.picture.pts, frame.picture.time_base) == (12_500_000, LIVE_TIME_BASE)


def test_a_file_s_missing_tags_stay_missing():
    frame = NormaliseCamera(is_device=False)(picture(0, 64, 48), 0.0)
    assert (frame.tags.matrix, frame.tags.range, frame.tags.primaries) == (2, 0, 2)


def test_odd_sizes_become_even():
    frame = NormaliseCamera(is_device=True)(picture(0, 65, 47, "yuv422p"), 0.0)
    assert (frame.width_px, frame.height_px) == (66, 48)


@pytest.mark.parametrize(
    ("aspect", "size"),
    [(Fraction(16, 11), (140, 64)), (Fraction(8, 9), (96, 72)), (Fraction(1000), (96, 64))],
)
def test_a_film_s_pixels_become_square_unless_it_claims_nonsense(tmp_path, aspect, size):
    clip = make_clip(tmp_path / "in.mp4", frames=2, sample_aspect_ratio=aspect)
    with closing(Camera(CameraSettings(name=str(clip)), pytest.fail)) as camera:
        frame = next(camera.frames())
    assert (frame.width_px, frame.height_px) == size


def test_square_pixels_keep_what_the_picture_means():
    shown = picture(0, 64, 48, "yuvj420p")
    shown.color_range, shown.colorspace = 2, 5
    shown.color_primaries = shown.color_trc = 6
    plane_views(shown, 8)[0][:] = 255
    frame = NormaliseCamera(is_device=False, pixel_aspect=Fraction(2))(shown, 0.0)
    assert frame.tags == NormaliseCamera(is_device=False)(shown, 0.0).tags
    assert frame.width_px == 128
    assert frame.planes[0].min() == 255


def test_a_name_too_long_for_any_file_is_refused_in_one_line():
    with pytest.raises(InputError, match="cannot be read"):
        Camera(CameraSettings(name="x" * 5000), pytest.fail)


def test_times_increase_strictly_even_where_two_pictures_come_at_once():
    door = NormaliseCamera(is_device=True)
    pts = [door(picture(i, 16, 16), at).pts for i, at in enumerate((0.0, 0.0, 1.0, 0.5))]
    assert pts == [0, 1, 1_000_000, 1_000_001]


@pytest.mark.parametrize("size", [(64, 64), (32, 16), (200, 48), (63, 31)])
def test_another_size_is_fitted_into_the_first_with_its_shape_kept(size):
    door = NormaliseCamera(is_device=True)
    door(picture(0, 64, 48), 0.0)
    other = picture(0, *size)
    for index, plane in enumerate(plane_views(other, 8)):
        plane[:] = 90 if index else 200
    frame = door(other, 1.0)
    assert (frame.width_px, frame.height_px) == (64, 48)
    filled = frame.planes[0] > 100
    width, height = filled.any(0).sum(), filled.any(1).sum()
    assert width == 64 or height == 48
    assert abs(width / height - size[0] / size[1]) <= 0.2 * size[0] / size[1]
    assert {16, 200} >= set(np.unique(frame.planes[0])[[0, -1]])


def test_another_range_is_brought_to_that_of_the_first():
    door = NormaliseCamera(is_device=True)
    door(picture(0, 64, 48, "yuvj420p"), 0.0)
    other = picture(0, 64, 48, "yuv420p")
    plane_views(other, 8)[0][:] = 235
    frame = door(other, 1.0)
    assert frame.tags.range == 2 and (frame.planes[0] == 255).all()


@pytest.mark.parametrize("degrees", [0, 90, 180, 270])
def test_upright_turns_the_planes_counter_clockwise(degrees):
    frame = NormaliseCamera(is_device=True)(picture(5, 64, 48), 3.0)
    frame.rotation_degrees = degrees
    turned = upright(frame)
    assert turned.pts == frame.pts and (turned is frame.picture) == (degrees == 0)
    for new, old in zip(plane_views(turned, 8), frame.planes, strict=True):
        np.testing.assert_array_equal(new, np.rot90(old, degrees // 90))


# -- files -------------------------------------------------------------------------------------------


def test_a_timeline_counts_from_the_first_frame_whatever_its_time():
    line = Timeline(0.1)
    assert [line(t) for t in (-5.0, -4.9, -4.7)] == pytest.approx([0, 0.1, 0.3])


def test_missing_and_repeated_times_are_mended_and_do_not_drift():
    line = Timeline(0.1)
    got = [line(t, 0.1) for t in (0.0, None, 0.2, 0.2, 0.1, 0.5, 0.6)]
    assert got == pytest.approx([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])


@pytest.mark.parametrize("jump", [3600.0, -3600.0])
def test_a_clock_that_jumps_is_one_frame_long(jump):
    line = Timeline(0.1)
    assert [line(t) for t in (0.0, 0.1, jump, jump + 0.1)] == pytest.approx([0, 0.1, 0.2, 0.3])


def test_another_pass_goes_on_where_the_last_ended():
    line = Timeline(0.1)
    first = [line(t, 0.1) for t in (1.0, 1.1)]
    line.begin_pass()
    assert first + [line(t, 0.1) for t in (1.0, 1.1)] == pytest.approx([0, 0.1, 0.2, 0.3])


@given(st.lists(st.one_of(st.none(), st.floats(-1e6, 1e6)), max_size=30))
def test_the_times_of_a_timeline_always_increase(times):
    line = Timeline(1 / 30)
    got = [line(t) for t in times]
    assert all(a < b for a, b in itertools.pairwise(got))


def played(path, count=None, **settings):
    """[(frame, seconds between when it was due and when it came)]"""
    camera = Camera(CameraSettings(name=str(path), **settings), pytest.fail)
    got = []
    for frame in camera.frames():
        got.append((frame, time.monotonic() - frame.seconds))
        if len(got) == count:
            camera.close()
    return camera, got


def test_a_file_ends_where_it_ends_and_no_frame_comes_before_it_is_due(tmp_path):
    camera, got = played(make_clip(tmp_path / "in.mp4", frames=8))
    assert len(got) + camera.dropped == 8 and camera.path == tmp_path / "in.mp4"
    assert all(late >= -1e-5 for _, late in got)
    steps = np.diff([frame.seconds for frame, _ in got])
    assert steps == pytest.approx(np.round(steps * 30) / 30, abs=1e-5)


def test_a_variable_rate_and_a_late_beginning_are_played_as_they_are(tmp_path):
    pts = [500, 520, 600, 610, 700]
    path = make_clip(tmp_path / "in.mkv", pts=pts, time_base=Fraction(1, 1000))
    _, got = played(path)
    times = np.array([frame.seconds for frame, _ in got]) - got[0][0].seconds
    assert set(np.round(times, 3)) <= {0, 0.02, 0.1, 0.11, 0.2}


@pytest.mark.parametrize("end", ["mp4", "avi"])
def test_a_loop_has_no_seam(tmp_path, end, monkeypatch):
    path, now = make_clip(tmp_path / f"in.{end}", "mjpeg", frames=5, pix_fmt="yuvj420p"), [100.0]
    monkeypatch.setattr(camera_file.time, "monotonic", lambda: now[0])
    camera = Camera(CameraSettings(name=str(path), loop=True), pytest.fail)
    camera._source._closing = FakeWait(now)
    got = [frame.seconds for frame in itertools.islice(camera.frames(), 14)]
    assert np.diff(got) == pytest.approx(1 / 30, abs=1e-5)
    assert camera.damaged == camera.dropped == 0


def test_a_file_cannot_be_late_for_ever(tmp_path, monkeypatch):
    """After a stall nothing old is shown, and the clock is the one it began with."""
    path = make_clip(tmp_path / "in.mp4", frames=60, options={"g": "10"})
    now = [100.0]
    monkeypatch.setattr(camera_file.time, "monotonic", lambda: now[0])
    camera = Camera(CameraSettings(name=str(path)), pytest.fail)
    camera._source._closing = FakeWait(now)
    frames = camera.frames()
    first = next(frames)
    now[0] += 1.5  # 45 frames
    later = list(frames)
    assert later[0].seconds >= now[0] - 1.5 and later[0].seconds - first.seconds >= 1.3
    assert all(abs((f.seconds - 100) * 30 - round((f.seconds - 100) * 30)) < 1e-3 for f in later)
    assert len(later) + 1 + camera.dropped == 60


def test_a_frame_that_was_waited_for_while_the_process_stood_still_is_left_out(
    tmp_path, monkeypatch
):
    path, now = make_clip(tmp_path / "in.mp4", frames=6), [100.0]
    monkeypatch.setattr(camera_file.time, "monotonic", lambda: now[0])
    camera = Camera(CameraSettings(name=str(path)), pytest.fail)
    camera._source._closing = FakeWait(now)
    frames = camera.frames()
    next(frames)
    camera._source._closing.stands_still = 0.12
    rest = [round((frame.seconds - 100) * 30) for frame in frames]
    assert rest == [2, 3, 4, 5] and camera.dropped == 1


class FakeWait:
    """An Event for a clock that only moves when somebody waits, once by too much."""

    def __init__(self, now):
        self.now = now
        self.stands_still = 0.0

    def is_set(self):
        return False

    def wait(self, seconds):
        self.now[0] += seconds + self.stands_still
        self.stands_still = 0.0
        return False


def test_close_wakes_who_waits_for_a_frame(tmp_path):
    path = make_clip(tmp_path / "in.mkv", pts=[0, 9000], time_base=Fraction(1, 1000))
    camera = Camera(CameraSettings(name=str(path)), pytest.fail)
    frames = camera.frames()
    next(frames)
    threading.Timer(0.05, camera.close).start()
    began = time.monotonic()
    assert next(frames, None) is None
    assert time.monotonic() - began < 8  # the next frame is due after nine seconds


def test_damage_in_a_file_ends_nothing(tmp_path):
    path = make_clip(tmp_path / "in.avi", "mjpeg", frames=12, pix_fmt="yuvj420p")
    damage(path)
    camera, got = played(path)
    assert len(got) + camera.dropped + camera.damaged >= 11


def test_a_rotated_file_says_how_it_is_turned(tmp_path):
    path = make_clip(tmp_path / "in.mp4", frames=2, rotation_degrees=90)
    assert {frame.rotation_degrees for frame, _ in played(path)[1]} == {90}


def test_colours_that_cannot_be_converted_are_one_line(tmp_path):
    path = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt="yuv444p", colorspace=8, frames=2)
    with pytest.raises(DecodeError, match=r"yuv444p, matrix 8 .* cannot be converted"):
        played(path)


# -- settings and names ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "wrong", [{"size": "720p"}, {"size": "0x5"}, {"rate": 0}, {"pixels": "h264"}, {"name": ""}]
)
def test_settings_that_mean_nothing_are_refused_in_a_line(wrong):
    with pytest.raises(UsageError) as caught:
        CameraSettings(**wrong)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["http://host/x.mp4", "concat:a|b", "missing.mp4"])
def test_only_files_of_this_machine_are_played(name):
    with pytest.raises(InputError, match="does not exist"):
        Camera(CameraSettings(name=name), pytest.fail)


def test_no_camera_at_all_says_what_was_looked_for(monkeypatch):
    monkeypatch.setattr(camera_device, "devices_found", list)
    with pytest.raises(InputError, match=r"no camera was found.*give a video file in its place"):
        Camera(CameraSettings(), pytest.fail)


def test_mjpeg_is_tried_before_raw_pixels_and_then_anything():
    wish = camera_device.CameraRequest("1280x720", 30, None)
    tried = attempts(wish, "v4l2")
    assert [one.get("input_format") for one in tried] == ["mjpeg", "yuyv422", None, None, None]
    assert tried[0]["video_size"] == "1280x720" and set(tried[-1]) == {"fflags"}
    raw = attempts(camera_device.CameraRequest(None, None, "yuyv422"), "v4l2")
    assert [one.get("input_format") for one in raw] == ["yuyv422", "mjpeg", None]
    assert attempts(wish, "dshow")[0]["vcodec"] == "mjpeg"
    assert attempts(wish, "avfoundation")[0]["framerate"] == "30"


def test_a_picture_that_waited_is_told_by_its_stamp_on_whatever_clock():
    fresh = Freshness()
    assert fresh(1000.0, 5.0, 0.03) == 5.0
    assert fresh(1000.1, 5.1, 0.0) == pytest.approx(5.1, abs=1e-4)
    assert fresh(1000.2, 5.25, 0.0) == pytest.approx(5.2, abs=1e-4)  # it came when it came
    assert fresh(1000.3, 7.1, 0.0) is None
    assert fresh(1007.0, 12.0, 0.03) == 12.0
    assert fresh(9.0, 12.1, 0.0) == 12.1  # the clock was set anew
    assert fresh(None, 12.2, 0.0) == 12.2


def test_a_camera_whose_pictures_take_longer_from_now_on_is_believed():
    fresh = Freshness()
    fresh(0.0, 0.0, 0.03)
    got = [fresh(at - 0.3, at, 0.2) for at in (1.0, 1.2, 1.4)]
    assert got == [None, 1.2, 1.4]


# -- a faked device ----------------------------------------------------------------------------------


class FakeDevice:
    """What FFmpeg would open: gives the packets of a clip once it may begin, then does what it was told."""

    def __init__(self, path, end, begin=None):
        self.file = av.open(str(path))
        self.streams = self.file.streams
        self.end, self.begin = end, begin
        self.closed = False

    def demux(self, video):
        if self.begin:
            self.begin.wait(20)
        for packet in self.file.demux(video):
            if packet.size:
                yield self.changed(packet)
        self.end()

    def changed(self, packet):
        return packet

    def close(self):
        self.closed = True
        self.file.close()


def unplugged():
    raise OSError(19, "No such device")


@pytest.fixture
def plug(monkeypatch):
    """plug(device, ...): what opening a camera gives, time after time; an exception is raised."""
    monkeypatch.setattr(camera_device, "_RETRY_SECONDS", 0.01)
    opened = []

    def setup(*devices):
        rest = list(devices)

        def open_camera(name, system, options):
            opened.append((name, options))
            one = rest.pop(0) if rest else OSError(19, "No such device")
            if isinstance(one, Exception):
                raise one
            return one

        monkeypatch.setattr(camera_device, "open_camera", open_camera)
        return opened

    return setup


def mjpeg(tmp_path, name="cam.avi", **more):
    more = {"frames": 6, "pix_fmt": "yuvj422p", "size_wh": (64, 48), **more}
    return make_clip(tmp_path / name, "mjpeg", **more)


def settings(**more):
    return CameraSettings(**{"name": "/dev/video0", "size": None, "rate": None, **more})


def test_the_newest_picture_is_given_and_the_others_are_counted(tmp_path, plug):
    begin, ended, stay = threading.Event(), threading.Event(), threading.Event()
    plug(FakeDevice(mjpeg(tmp_path, frames=6), lambda: (ended.set(), stay.wait()), begin))
    camera = Camera(settings(), lambda line: None)
    frames = camera.frames()
    begin.set()
    assert ended.wait(20)
    first = next(frames)
    assert camera.dropped == 5 and first.seconds <= time.monotonic()
    stay.set()
    camera.close()
    assert next(frames, None) is None


def test_what_came_before_anybody_asked_is_not_missed(tmp_path, plug):
    ended, stay = threading.Event(), threading.Event()
    plug(FakeDevice(mjpeg(tmp_path, frames=6), lambda: (ended.set(), stay.wait())))
    camera = Camera(settings(), lambda line: None)
    assert ended.wait(20)  # while nets were loaded, say
    next(camera.frames())
    stay.set()
    camera.close()
    assert camera.dropped == 0


def test_a_camera_that_opens_and_gives_nothing_is_said_once(tmp_path, plug):
    lines, opened = [], []
    path = mjpeg(tmp_path)

    class Dumb(FakeDevice):
        def demux(self, video):
            opened.append(self)
            if len(opened) == 5:
                threading.Thread(target=camera.close).start()
            unplugged()

    plug(*(Dumb(path, unplugged) for _ in range(6)))
    camera = Camera(settings(), lines.append)
    assert list(camera.frames()) == [] and len(opened) >= 5
    assert lines == ["camera /dev/video0 is gone: waiting for it"]


def test_unplugged_is_said_once_and_so_is_its_return_and_the_clock_goes_on(tmp_path, plug):
    lines, back = [], threading.Event()
    gone = OSError(19, "No such device")
    second = FakeDevice(mjpeg(tmp_path, "b.avi", size_wh=(128, 48)), back.wait)
    plug(FakeDevice(mjpeg(tmp_path), unplugged), gone, gone, second)
    camera = Camera(settings(), lines.append)
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

    def say(line):
        lines.append(line)
        threading.Timer(0.05, camera.close).start()  # it waits by then, as a rule

    begin = threading.Event()
    plug(FakeDevice(mjpeg(tmp_path), unplugged, begin))
    camera = Camera(settings(), say)
    begin.set()
    list(camera.frames())  # it ends
    assert lines == ["camera /dev/video0 is gone: waiting for it"]


def test_a_camera_that_hangs_is_said_and_close_does_not_wait_for_it(tmp_path, plug, monkeypatch):
    monkeypatch.setattr(camera_device, "_SILENT_SECONDS", 0.05)
    lines, ended, hanging = [], threading.Event(), threading.Event()
    plug(FakeDevice(mjpeg(tmp_path), lambda: (ended.set(), hanging.wait())))

    def say(line):
        lines.append(line)
        threading.Timer(0.05, camera.close).start()

    camera = Camera(settings(), say)
    assert ended.wait(20)
    list(camera.frames())
    hanging.set()
    assert lines == ["camera /dev/video0 sends no pictures: waiting for it"]
    assert camera.notice == lines[0]


def test_a_camera_whose_pictures_cannot_be_used_ends_the_run(tmp_path, plug, monkeypatch):
    def refuse(self, picture):
        raise DecodeError("no")

    monkeypatch.setattr(NormaliseCamera, "_converted", refuse)
    plug(FakeDevice(mjpeg(tmp_path), unplugged))
    camera = Camera(settings(), pytest.fail)
    with pytest.raises(DecodeError, match="no"):
        next(camera.frames())


class Damaged(FakeDevice):
    """One packet breaks off, one is no JPEG at all, one is empty, one has rubbish behind its end."""

    def changed(self, packet):
        data = bytes(packet)
        number = packet.pts
        odd = {1: data[: len(data) // 2], 3: b"no picture", 5: b"", 6: data + b"rubbish"}
        cut = odd.get(number, data)
        return av.Packet(cut)  # without a stamp, by which a busy machine would leave some out


def test_damaged_jpegs_are_counted_and_end_nothing(tmp_path, plug):
    begin, ended, stay = threading.Event(), threading.Event(), threading.Event()
    plug(Damaged(mjpeg(tmp_path, frames=8), lambda: (ended.set(), stay.wait()), begin))
    camera = Camera(settings(), lambda line: None)
    frames = camera.frames()
    begin.set()
    assert ended.wait(20)
    assert camera.damaged == 3 and camera.dropped == 4  # the newest of five waits
    frame = next(frames)
    assert (frame.pix_fmt, frame.tags.range) == ("yuv420p", 2)
    stay.set()
    camera.close()


def raw_yuyv(path, frames=4, size_wh=(64, 48)):
    """YUYV as a camera gives it, in AVI."""
    with av.open(str(path), "w") as out:
        stream = out.add_stream("rawvideo", rate=10)
        stream.width, stream.height, stream.pix_fmt = *size_wh, "yuyv422"
        for index in range(frames):
            shown = picture(index, *size_wh, "yuyv422")
            shown.pts, shown.time_base = index, Fraction(1, 10)
            out.mux(stream.encode(shown))
    return path


def test_yuyv_is_painted_on_and_what_the_camera_gives_instead_is_one_line(tmp_path, plug):
    lines, stay = [], threading.Event()
    no = av.error.ArgumentError(22, "Invalid argument")
    opened = plug(no, FakeDevice(raw_yuyv(tmp_path / "cam.avi"), stay.wait))
    camera = Camera(settings(size="1280x720", rate=30, pixels="mjpeg"), lines.append)
    frame = next(camera.frames())
    stay.set()
    camera.close()
    assert [options.get("input_format") for _, options in opened] == ["mjpeg", "yuyv422"]
    assert lines == [
        "camera /dev/video0 gives 64x48, not 1280x720; 10 frames a second, not 30; yuyv422, not mjpeg"
    ]
    assert (frame.tags.matrix, frame.tags.range, camera.rate) == (6, 1, 10)
    assert frame.picture.format.name == "yuv420p"


@pytest.mark.parametrize(("number", "told"), [(13, "group video"), (16, "another program uses it")])
def test_a_camera_that_may_not_be_opened_says_what_to_do(plug, number, told):
    opened = plug(OSError(number, "no"))
    with pytest.raises(InputError, match=told) as caught:
        Camera(settings(), pytest.fail)
    assert "\n" not in str(caught.value) and len(opened) == 1


class Scripted(FakeDevice):
    """Gives its packets at set times, with set stamps: script is [(stamped, read), ...]."""

    def __init__(self, path, end, begin, clock, script):
        super().__init__(path, end, begin)
        self.clock, self.script = clock, script

    def demux(self, video):
        self.begin.wait(20)
        for packet, (stamped, read) in zip(self.file.demux(video), self.script, strict=False):
            out = av.Packet(bytes(packet))
            out.pts, out.time_base = round((7000 + stamped) * 1e6), Fraction(1, 1_000_000)
            self.clock[0] = read
            yield out
        self.end()


def test_what_waited_in_the_driver_during_a_stall_is_not_shown(tmp_path, plug, monkeypatch):
    clock, shown = [0.0], []
    begin, ended, stay = threading.Event(), threading.Event(), threading.Event()
    monkeypatch.setattr(camera_device.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(
        camera_device.DeviceCamera, "_offer", lambda self, frame: shown.append(frame.seconds)
    )
    fresh = [(0.50, 0.50), (0.53, 0.53)]
    stalled = [(0.56, 1.56), (0.60, 1.56), (0.63, 1.56)]  # the first was being read when we stopped
    script = [*fresh, *stalled, (1.60, 1.60)]
    plug(Scripted(mjpeg(tmp_path), lambda: (ended.set(), stay.wait()), begin, clock, script))
    camera = Camera(settings(), lambda line: None)
    camera.frames()
    begin.set()
    assert ended.wait(20)
    stay.set()
    camera.close()
    assert shown == pytest.approx([0.50, 0.53, 1.60]) and camera.dropped == 3
