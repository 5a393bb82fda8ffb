"""Guards the speed of the product by counting work, since times are noise on a shared machine.

Each limit was set about a tenth above the count at that time. A change that needs more work per
frame raises the limit here, and docs/performance.md explains the benefit.
"""

import gc
from pathlib import Path

import av
import pytest
from makeup_video.benchmark.renderer import full_look
from makeup_video.pipeline import Settings, process_video, ready_look
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.surfaces.eyes import BothEyes
from people import resized_sample
from work import measure_work

SAMPLE = Path(__file__).parents[1] / "samples" / "in.mp4"
FRAMES = 40  # one face; the first few frames cost more
LIMITS = {
    "frames_converted": 0,  # no frame ever becomes RGB
    "net_runs_lips": 1.1,
    "net_runs_eye": 1.1,
    "net_runs_mesh": 0.65,
    "net_runs_detector": 0.2,
    # one for surfaces, one for products, and three that paint, whatever the regions are
    "kernels_launched": 5,
    "calls": 2150,
}


@pytest.fixture(scope="module")
def work():
    # fills the caches that all videos share, whatever tests came before
    measure_work(SAMPLE, full_look(), 8)
    return measure_work(SAMPLE, full_look(), FRAMES)


@pytest.mark.parametrize("name", LIMITS)
def test_a_frame_costs_no_more_work_than_its_limit(work, name):
    count = work.get(name, 0) if LIMITS[name] == 0 else work[name]  # what never happens has none
    assert count <= LIMITS[name]


def test_opencv_returns_little_more_than_a_third_of_a_frame(work):
    """In RGB; eyeshadow that covers all of the lid, up to the brow, is a third of it."""
    assert 0 < work["bytes_converted"] < 0.36 * 1280 * 720 * 3


def test_in_a_larger_frame_only_pixels_cost_more(work, tmp_path):
    clip = resized_sample(tmp_path / "larger.mp4", (2560, 1440), FRAMES)
    more = measure_work(clip, full_look(), FRAMES)
    for name in ("net_runs", "kernels_launched", "calls"):
        assert more[name] <= 1.1 * work[name]
    # OpenCV reads only half as many bytes of the larger frame
    assert more["bytes_converted"] <= 0.75 * 4 * work["bytes_converted"]


def test_a_frame_that_is_converted_is_counted(monkeypatch):
    paint = Composite.__call__

    def waste(self, item):
        item.frame.picture.reformat(format="rgb24")
        return paint(self, item)

    monkeypatch.setattr(Composite, "__call__", waste)
    assert measure_work(SAMPLE, full_look(), 12)["frames_converted"] > 0.5


def frames_and_faces():
    found = []
    for one in gc.get_objects():
        is_frame = isinstance(one, av.VideoFrame) and one.width == 1280
        found += [one] * (is_frame or isinstance(one, BothEyes | Face))
    return found


def test_no_frame_waits_for_the_garbage_collector(tmp_path):
    """Python's collector runs once in hundreds of frames; until then they would fill the memory."""
    gc.collect()
    gc.disable()
    try:
        before = frames_and_faces()  # left by other tests
        look = ready_look("cat-eye").look  # its lines along the lashes have the most objects
        process_video(SAMPLE, tmp_path / "out.mp4", look, Settings(end_seconds=FRAMES / 30))
        left = [one for one in frames_and_faces() if not any(one is old for old in before)]
        assert left == []
    finally:
        gc.enable()
