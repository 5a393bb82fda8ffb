"""The cost by number of faces, number of threads and video length. Nothing here is timed."""

from collections import Counter

import pytest
from makeup_video.benchmark import harness, scaling, videos
from makeup_video.pipeline import Look, UsageError, product
from makeup_video.pipeline.offline import run as offline
from makeup_video.pipeline.offline import video as offline_video
from people import SAMPLES

LOOK = Look(lips=product((150, 30, 70), "satin"), eyes=product((60, 80, 150), "satin", "eyes"))


@pytest.fixture
def bench(tmp_path):
    return harness.Bench(SAMPLES / "in.mp4", tmp_path, LOOK, seconds=0.5, rounds=1)


def test_faces_cost_by_their_number(bench, monkeypatch):
    monkeypatch.setattr(scaling, "FACES", (1, 2))
    found = scaling.by_faces(bench, 360)
    assert list(found["counts"]) == ["1", "2"]
    one, two = found["counts"].values()
    more = two["not_codec_cpu_ms"] - one["not_codec_cpu_ms"]
    assert found["further_face_cpu_ms"] == pytest.approx(more)


def test_faces_are_counted_on_a_clip_of_one(bench, monkeypatch):
    several = videos.Video(bench.source, (64, 48), 10, 2, False)
    monkeypatch.setattr(harness.Bench, "video", lambda *_, **__: several)
    with pytest.raises(UsageError, match="shows 2"):
        scaling.by_faces(bench, 360)


def test_threads_of_codecs_and_of_pocl_are_compared(bench, monkeypatch):
    monkeypatch.setattr(scaling, "SHARED", ((1, 2, 1), (0, 0, 4)))
    monkeypatch.setattr(scaling, "BARE_THREADS", ((0, 0),))
    monkeypatch.setattr(scaling, "_POCL_THREADS", (0, 1))
    real, environments = scaling.run_command, []

    def noted(*words, environment, **more):
        environments.append(environment)
        return real(*words, environment=environment, **more)

    monkeypatch.setattr(scaling, "run_command", noted)
    found = scaling.by_threads(bench, bench.video(144), "threads")
    kinds = Counter(name.split(":")[0] for name in found["settings"])
    assert kinds == {"bare": 1, "product": 2, "command": 2}
    as_usual = environments.count({})
    assert 0 < as_usual == len(environments) / 2
    # the device that the product takes ignores the number of threads
    assert all(env["POCL_DEVICES"] == "pthread" for env in environments if env)
    assert found["best"] in found["settings"] and found["best"].startswith("product")


def test_the_product_really_runs_with_other_threads(bench, monkeypatch):
    runs = []

    class Noted(offline.Runner):
        def __init__(self, source, stages, sink, *rest, **options):
            super().__init__(source, stages, sink, *rest, **options)
            runs[-1] += sink[1].threads, len(self.channels) - 1

    class NotedDecoder(offline_video.Decoder):
        def __init__(self, *args, threads, **options):
            super().__init__(*args, threads=threads, **options)
            runs.append((threads,))

    monkeypatch.setattr(offline, "Runner", Noted)
    monkeypatch.setattr(offline_video, "Decoder", NotedDecoder)
    video = bench.video(144).path
    for threads in ((1, 3, 2), (0, 0, 4)):
        scaling._run_with_threads(bench, video, *threads)
    assert runs == [(1, 3, 2), (0, 0, 4)]


def test_the_memory_of_a_long_video_is_sampled(bench):
    found = scaling.over_length(bench, 144, minutes=0.05)
    assert found["minutes"] == pytest.approx(0.05, rel=0.2) and found["frames"] >= 80
    assert found["memory"] and found["memory"] == sorted(found["memory"])
    assert max(size for _, size in found["memory"]) <= found["peak_memory_mb"] * 1.05
    assert found["growth"] > 0


def test_memory_grows_from_the_third_tenth_to_the_last(bench, monkeypatch):
    values = {"frames_out": 9, "fps": 1.0, "peak_memory_bytes": 0}
    values["memory"] = [[float(number), 100.0 + number] for number in range(100)]
    monkeypatch.setattr(scaling, "run_command", lambda *_, **__: values)
    found = scaling.over_length(bench, 144, minutes=0.01)
    assert found["growth"] == pytest.approx(194.5 / 124.5)
