"""The bench's comparisons and sums. Nothing here is timed."""

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.benchmark import (
    films as measure_clip,
)
from makeup_video.benchmark import (
    floor as measure_floor,
)
from makeup_video.benchmark import (
    harness as measure,
)
from makeup_video.benchmark import (
    runs as measure_run,
)
from makeup_video.benchmark import (
    stages as measure_stages,
)
from makeup_video.benchmark.runs import Run
from makeup_video.pipeline import InputError, Look, UsageError, product
from people import SAMPLES, clip, film, grey

LOOK = Look(product((150, 30, 70), "satin"), product((60, 80, 150), "satin", "eyes"))


@pytest.fixture
def bench(tmp_path):
    return measure.Bench(SAMPLES / "in.mp4", tmp_path, LOOK, seconds=0.5, rounds=1)


def runs():
    return st.builds(Run, st.integers(1, 999), st.floats(0.01, 99), st.floats(0, 99))


@given(st.lists(st.tuples(runs(), runs()), min_size=1, max_size=9))
def test_medians_lie_within_their_spread(pairs):
    ours, bare = map(list, zip(*pairs, strict=True))
    row = measure.middle(ours)
    low, high = row["fps_spread"]
    assert low <= row["fps"] <= high
    side = measure.beside(ours, bare)
    low, high = side["ratio_spread"]
    assert low <= high and side["ratio"] > 0
    assert measure.beside(ours, ours)["ratio"] == 1
    assert measure.beside(ours, ours)["not_codec_cpu_ms"] == 0
    assert measure.beside(ours, bare, ours)["not_codec_cpu_ms"] == 0
    assert measure.beside(ours, bare, ours)["ratio"] == side["ratio"]


def test_everyone_has_his_turn_and_every_round_begins_with_another(bench):
    done = []
    work = {name: lambda name=name: done.append(name) or Run(1, 1, 1) for name in "abc"}
    found = measure.in_turn(bench, "x", work, 4)
    assert "".join(done) == "abcbcacababc"
    assert {name: len(runs) for name, runs in found.items()} == {"a": 4, "b": 4, "c": 4}


def observed(*films):
    heard = measure_stages.Observed()
    for items in films:
        heard.start()
        for name, ms in items:
            heard(name, ms / 1000, ms / 2000)
    return heard


def test_the_first_hundred_frames_are_skipped_and_five_hundred_counted():
    items = [("faces", 1000)] * 100 + [("faces", ms) for ms in range(500)] + [("faces", 10**6)]
    row = observed(items, items).table(600)["faces"]
    assert row["mean_ms"] == row["p50_ms"] == pytest.approx(249.5)
    assert row["p95_ms"] == pytest.approx(474.05, abs=1)
    assert row["cpu_mean_ms"] == row["cpu_p50_ms"] == pytest.approx(249.5 / 2)


@given(st.integers(1, 700))
def test_of_a_short_film_something_is_left(frames):
    items = [("decode", 2)] * (frames + 1) + [("encode", 3)] * (frames + 1)
    table = observed(items).table(frames)
    assert list(table) == ["decode", "encode"]
    assert table["encode"]["mean_ms"] == pytest.approx(3)


def channel(fill):
    return {"capacity": 2, "mean_fill": fill}


STAGES = {name: {"mean_ms": ms} for name, ms in
          (("decode", 1), ("faces", 2), ("scene", 3), ("composite", 1), ("encode", 9))}  # fmt: skip


@pytest.mark.parametrize(
    ("fills", "waited_for"),
    [((0.1, 0.9), "encode"), ((0.9, 0.1), "scene"), ((0.0, 0.1), "decode")],
)
def test_the_bottleneck_is_who_is_waited_for(fills, waited_for):
    channels = dict(zip(("-> faces", "-> encode"), map(channel, fills), strict=True))
    assert measure_stages.bottleneck(channels, STAGES) == waited_for
    assert measure_stages.bottleneck({}, STAGES) == "decode"


def test_a_stage_with_a_thread_of_its_own_is_named_itself():
    channels = {f"-> {name}": channel(0.1) for name in list(STAGES)[1:]} | {"-> faces": channel(1)}
    assert measure_stages.bottleneck(channels, STAGES) == "faces"


def test_fills_are_medians_of_runs():
    runs = [{"-> faces": channel(fill)} for fill in (0.1, 0.9, 0.2)]
    assert measure_stages.fills(runs) == {"-> faces": channel(0.2)}


@pytest.mark.parametrize(("painted", "frames"), [(0, 1), (94, 100), (None, 10)])
def test_a_run_that_painted_too_little_counts_for_nothing(painted, frames):
    with pytest.raises(InputError, match=f"in {painted or 0} of {frames} frames, at least 95%"):
        measure_run.check_painted(painted, frames)


def test_so_does_a_film_where_the_face_leaves(tmp_path):
    source = film(tmp_path / "leaves.mkv", [*clip(20), *[grey()] * 10])
    with pytest.raises(InputError, match="of 30 frames"):
        measure_run.run_product(source, tmp_path / "out.mp4", LOOK)
    run, report = measure_run.run_product(source, tmp_path / "out.mp4", None)
    assert run.frames == report.frames_out == 30


def test_the_bare_loop_encodes_every_frame(tmp_path):
    source = film(tmp_path / "a.mkv", clip(10))
    run = measure_run.run_bare(source, tmp_path / "out.mp4", (1, 2))
    assert run.frames == 10 and run.fps > 0 and run.cpu_ms_per_frame > 0


def test_faces_cost_by_their_number(bench, monkeypatch):
    monkeypatch.setattr(measure, "FACES", (1, 2))
    found = measure.by_faces(bench, 360)
    assert list(found["counts"]) == ["1", "2"]
    one, two = found["counts"].values()
    more = two["not_codec_cpu_ms"] - one["not_codec_cpu_ms"]
    assert found["further_face_cpu_ms"] == pytest.approx(more)


def test_faces_are_counted_on_a_clip_of_one(bench, monkeypatch):
    several = measure_clip.Clip(bench.source, (64, 48), 10, 2, False)
    monkeypatch.setattr(measure.Bench, "clip", lambda *_, **__: several)
    with pytest.raises(UsageError, match="shows 2"):
        measure.by_faces(bench, 360)


def test_threads_of_codecs_and_of_pocl_are_compared(bench, monkeypatch):
    monkeypatch.setattr(measure, "SHARED", ((1, 2, 1), (0, 0, 4)))
    monkeypatch.setattr(measure, "BARE_THREADS", ((0, 0),))
    monkeypatch.setattr(measure, "_POCL_THREADS", (1,))
    found = measure.by_threads(bench, bench.clip(144), "threads")
    kinds = Counter(name.split(":")[0] for name in found["settings"])
    assert kinds == {"bare": 1, "product": 2, "command": 1}
    assert found["best"] in found["settings"] and found["best"].startswith("product")


def test_the_codec_alone_has_the_threads_that_the_product_chooses(tmp_path, monkeypatch):
    seen = {}

    class Noted(measure.Decoder):
        def __init__(self, *given, threads, **named):
            super().__init__(*given, threads=threads, **named)
            seen["decoder"] = threads

    class NotedEncoder(measure.VideoEncoder):
        def __init__(self, *given):
            super().__init__(*given)
            seen["encoder"] = self.threads

    monkeypatch.setattr(measure.process, "Decoder", Noted)
    monkeypatch.setattr(measure.process, "VideoEncoder", NotedEncoder)
    source = film(tmp_path / "a.mkv", clip(10))
    measure_run.run_product(source, tmp_path / "out.mp4", LOOK)
    assert (seen["decoder"], seen["encoder"]) == measure.own_threads()


def test_the_product_really_runs_with_other_threads(bench, monkeypatch):
    seen = []

    class Noted(measure.Runner):
        def __init__(self, source, stages, sink, **named):
            super().__init__(source, stages, sink, **named)
            seen.append((sink[1].threads, len(self.channels) - 1))

    monkeypatch.setattr(measure, "Runner", Noted)
    film = bench.clip(144).path
    for _, encoder, workers in ((1, 3, 2), (0, 0, 4)):
        measure._run_shared(bench, film, 1, encoder, workers)
    assert seen == [(3, 2), (0, 4)]


def test_a_long_film_tells_its_memory_as_it_goes(bench):
    found = measure.over_length(bench, 144, minutes=0.05)
    assert found["minutes"] == pytest.approx(0.05, rel=0.2) and found["frames"] >= 80
    assert found["memory"] and found["memory"] == sorted(found["memory"])
    assert max(size for _, size in found["memory"]) <= found["peak_memory_mb"] * 1.05
    assert found["growth"] > 0


@pytest.mark.parametrize(
    ("node", "operations"),
    [
        (("Conv", [[1, 3, 8, 8], [16, 3, 3, 3], [16]], [1, 16, 4, 4]), 2 * 27 * 16 * 16),
        (("Conv", [[2, 8, 4, 4], [8, 1, 5, 5], [8]], [2, 8, 4, 4]), 2 * 25 * 2 * 8 * 16),
        (("FusedConv", [[1, 3, 8, 8], [16, 3, 1, 1]], [1, 16, 8, 8]), 2 * 3 * 16 * 64),
        (("Gemm", [[1, 60], [60, 240], [240]], [1, 240]), 2 * 60 * 240),
        (("MatMul", [[1, 60], [60, 240]], [1, 240]), 2 * 60 * 240),
        (("Relu", [[1, 16, 4, 4]], [1, 16, 4, 4]), 0),
    ],
)
def test_operations_of_a_net_are_those_of_its_weights(node, operations):
    name, inputs, output = node
    notes = {"op_name": name, "input_type_shape": [{"float": shape} for shape in inputs],
             "output_type_shape": [{"float": output}]}  # fmt: skip
    assert measure_floor.operations_of(notes) == operations


def test_the_nets_of_a_face_take_millions_of_operations(tmp_path):
    still = film(tmp_path / "a.mkv", clip(8))
    nothing = film(tmp_path / "b.mkv", [grey()] * 8)
    face, none = map(measure_floor.net_operations, (still, nothing))
    assert face > none > 1e6


def test_a_larger_copy_takes_longer():
    assert 0 < measure_floor.copy_ms(1000) < measure_floor.copy_ms(10**9)
