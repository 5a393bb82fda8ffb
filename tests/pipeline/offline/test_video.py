"""Progress of a video that its caller breaks off with an error: no output and no part file."""

import time
from types import SimpleNamespace

import pytest
from makeup_video.pipeline import Look, Settings, process_looks, process_video
from makeup_video.pipeline.media.encode import VideoEncoder
from makeup_video.pipeline.offline.video import channel_frames
from people import clip, write_video


class OwnError(Exception):
    pass


def one(src, folder, settings, on_progress):
    process_video(src, folder / "out.mkv", None, settings, on_progress)


def several(src, folder, settings, on_progress):
    def tick(outputs, *figures):
        on_progress(*figures)

    process_looks(src, {folder / "out.mkv": Look()}, settings, tick)


@pytest.mark.parametrize("run", [one, several])
def test_an_error_while_it_is_reported_leaves_no_part(tmp_path, run):
    src = write_video(tmp_path / "in.mkv", clip(40))

    def tick(done, *figures):
        if done:
            raise OwnError

    for _ in range(2):  # the second run finds nothing in its way
        with pytest.raises(OwnError):
            run(src, tmp_path, Settings(preset="veryslow"), tick)
        assert [path.name for path in tmp_path.iterdir()] == ["in.mkv"]


@pytest.mark.parametrize("run", [one, several])
def test_no_report_comes_once_an_output_is_being_finished(tmp_path, monkeypatch, run):
    src, out = write_video(tmp_path / "in.mkv", clip(3)), tmp_path / "out.mkv"
    out.write_text("old")
    finish, finishing = VideoEncoder.finish, []

    def slow(self, stopped):
        finishing.append(True)
        time.sleep(0.5)
        finish(self, stopped)

    def tick(done, *figures):
        if finishing:
            raise OwnError

    monkeypatch.setattr(VideoEncoder, "finish", slow)
    run(src, tmp_path, Settings(overwrite=True), tick)
    assert out.read_bytes()[:3] != b"old"


@pytest.mark.parametrize(
    ("height_px", "bit_depth", "count"), [(144, 8, 3), (720, 8, 3), (720, 10, 1), (2160, 10, 1)]
)
def test_fewer_large_frames_wait_between_threads(height_px, bit_depth, count):
    source = SimpleNamespace(frame_px=height_px * height_px * 16 // 9, bit_depth=bit_depth)
    assert channel_frames(source) == count
