"""What a run opened is gone when it ends: no encoder waits for Python's garbage collector, which
may start only after dozens of runs."""

import gc
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from types import SimpleNamespace

import av
import pytest
from makeup_video.kernels.program import Device
from makeup_video.pipeline import (
    DecodeError,
    Painter,
    Settings,
    apply_look,
    paint_frames,
    process_looks,
    process_video,
    ready_look,
)
from makeup_video.pipeline.engine import machine
from makeup_video.pipeline.files.output_file import OutputFile
from makeup_video.pipeline.media.decode import Decoder
from makeup_video.pipeline.media.encode import VideoEncoder
from makeup_video.pipeline.offline.stages import FaceRun
from media import add_video, encode_frames, make_clip
from people import SAMPLES, clip
from workers import InThisProcess

HELD = (VideoEncoder, Decoder, OutputFile, FaceRun, Device)
LOOK = ready_look("berry").look


def held():
    return [one for one in gc.get_objects() if isinstance(one, HELD)]


def one_look(folder):
    process_video(SAMPLES / "in.mp4", folder / "out.mp4", LOOK, Settings(end_seconds=0.2))


def several_looks(folder):
    looks = {folder / f"{name}.mp4": ready_look(name).look for name in ("berry", "glam")}
    process_looks(SAMPLES / "in.mp4", looks, Settings(end_seconds=0.2))


def pictures(folder):
    process_video(SAMPLES / "portrait.jpg", folder / "one.jpg", LOOK)
    process_looks(SAMPLES / "portrait.jpg", {folder / "a.jpg": LOOK, folder / "b.jpg": LOOK})


def segments(folder):
    src = make_clip(folder / "in.mp4", frames=60, options={"g": "15", "sc_threshold": "0"})
    settings = Settings(split_minutes=Fraction(1, 60))
    report = process_video(src, folder / "out.mp4", LOOK, settings, workers=[InThisProcess()])
    assert report.segments > 1


def a_video_that_fails(folder):
    data = b""
    for size_wh in ((96, 64), (128, 96)):
        part = folder / "part.h264"
        with av.open(str(part), "w", format="h264") as out:
            encode_frames(out, add_video(out, size_wh=size_wh), range(10))
        data += part.read_bytes()
    (folder / "in.h264").write_bytes(data)
    message = ""
    try:  # pytest.raises would keep the traceback
        process_video(folder / "in.h264", folder / "out.mp4", LOOK)
    except DecodeError as error:
        message = str(error)
    assert "changes from 96x64 yuv420p to 128x96 yuv420p at 0." in message


def frames(folder):
    list(paint_frames(clip(2), LOOK))
    painter = Painter(LOOK)
    painter(clip(1)[0], 0)


def threads(folder):
    with ThreadPoolExecutor(1) as pool:
        pool.submit(apply_look, clip(1)[0], LOOK).result()


RUNS = [one_look, several_looks, pictures, segments, a_video_that_fails, frames, threads]


@pytest.mark.parametrize("run", RUNS)
def test_nothing_waits_for_the_garbage_collector(tmp_path, monkeypatch, run):
    monkeypatch.setattr(machine, "gc", SimpleNamespace(collect=lambda generation=2: 0))
    apply_look(clip(1)[0], LOOK)  # creates the kernel that all threads share
    gc.collect()
    gc.disable()
    try:
        before = held()  # left by other tests
        run(tmp_path)
        assert [one for one in held() if not any(one is old for old in before)] == []
    finally:
        gc.enable()
