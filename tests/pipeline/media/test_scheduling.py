"""Encoders leave the scheduling of threads as it was."""

import contextlib
import dataclasses
import os
import sys
import threading
from fractions import Fraction

import av
import pytest
from live_doubles import frame
from makeup_video.pipeline import Settings, process_video
from makeup_video.pipeline.live.sinks.encoder import LiveEncoder
from makeup_video.pipeline.media.codecs import CODECS
from makeup_video.pipeline.media.mux import Muxer
from makeup_video.pipeline.media.scheduling import same_scheduling
from media import make_clip

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="only Linux lists the threads of a process"
)


def policies():
    """Each thread's policy; a thread may end between its listing and the question."""
    seen = {}
    for thread in os.listdir("/proc/self/task"):
        with contextlib.suppress(ProcessLookupError):
            seen[thread] = os.sched_getscheduler(int(thread))
    return seen


def test_the_caller_and_new_threads_get_the_caller_s_policy():
    before, stop = policies(), threading.Event()
    with same_scheduling():
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
        thread = threading.Thread(target=stop.wait)
        thread.start()
        assert policies()[str(thread.native_id)] == os.SCHED_BATCH
    after = policies()
    stop.set()
    thread.join()
    assert set(after.values()) == {os.sched_getscheduler(0)} == set(before.values())


def test_other_threads_keep_the_policy_that_they_had():
    ready, stop = threading.Event(), threading.Event()

    def work():
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
        ready.set()
        stop.wait()

    thread = threading.Thread(target=work)
    thread.start()
    ready.wait()
    with same_scheduling():
        pass
    after = policies()[str(thread.native_id)]
    stop.set()
    thread.join()
    assert after == os.SCHED_BATCH


def test_an_error_passes_and_the_policy_is_restored():
    before = os.sched_getscheduler(0)
    with pytest.raises(ValueError, match="refused"), same_scheduling():
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
        raise ValueError("refused")
    assert os.sched_getscheduler(0) == before


@pytest.mark.parametrize("codec", ["av1", "h264", "hevc", "vp9"])
def test_no_thread_of_a_run_gets_another_policy(codec, tmp_path, monkeypatch):
    seen = {}

    def write_and_look(muxer, packet, write=Muxer.write):
        seen.update(policies())
        write(muxer, packet)

    monkeypatch.setattr(Muxer, "write", write_and_look)
    src = make_clip(tmp_path / "in.mp4")
    process_video(src, tmp_path / "out.mkv", None, Settings(codec=codec))
    assert set(seen.values()) == {os.sched_getscheduler(0)}


@pytest.mark.parametrize("codec", ["av1", "vp9"])
def test_no_thread_of_a_recording_gets_another_policy(codec, tmp_path):
    before = set(policies().values())
    with av.open(str(tmp_path / "out.mkv"), "w") as out:
        encoder = LiveEncoder(out, CODECS[codec].encoder, {}, big(0), Fraction(30))
        for number in range(8):
            list(encoder(big(number).picture))
        assert set(policies().values()) == before
        list(encoder(None))


def big(number):
    """A frame that is large enough for every encoder."""
    picture = av.VideoFrame(128, 128, "yuv420p")
    picture.pts = number * 33_000
    return dataclasses.replace(frame(number), picture=picture, pts=number * 33_000)
