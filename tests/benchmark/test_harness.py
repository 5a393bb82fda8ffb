"""Interleaved comparisons and their medians. Nothing here is timed."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.benchmark import harness
from makeup_video.benchmark.runs import Run
from makeup_video.pipeline import Look, UsageError, product
from makeup_video.pipeline.look.kinds import PARTS
from people import SAMPLES

LOOK = Look(lips=product((150, 30, 70), "satin"), eyes=product((60, 80, 150), "satin", "eyes"))


@pytest.fixture
def bench(tmp_path):
    return harness.Bench(SAMPLES / "in.mp4", tmp_path, LOOK, seconds=0.5, rounds=1)


def runs():
    return st.builds(Run, st.integers(1, 999), st.floats(0.01, 99), st.floats(0, 99))


@given(st.lists(st.tuples(runs(), runs()), min_size=1, max_size=9))
def test_medians_lie_within_their_spread(pairs):
    ours, bare = map(list, zip(*pairs, strict=True))
    row = harness.middle(ours)
    low, high = row["fps_spread"]
    assert low <= row["fps"] <= high
    side = harness.beside(ours, bare)
    low, high = side["ratio_spread"]
    assert low <= high and side["ratio"] > 0
    assert harness.beside(ours, ours)["ratio"] == 1
    assert harness.beside(ours, ours)["not_codec_cpu_ms"] == 0
    assert harness.beside(ours, bare, ours)["not_codec_cpu_ms"] == 0
    assert harness.beside(ours, bare, ours)["ratio"] == side["ratio"]


def test_every_round_begins_with_another_piece_of_work(bench):
    done = []
    work = {name: lambda name=name: done.append(name) or Run(1, 1, 1) for name in "abc"}
    found = harness.in_turn(bench, "x", work, 4)
    assert "".join(done) == "abcbcacababc"
    assert {name: len(runs) for name, runs in found.items()} == {"a": 4, "b": 4, "c": 4}


def test_a_look_that_paints_nothing_is_refused(tmp_path):
    with pytest.raises(UsageError, match=f"paints nothing: give one with {' or '.join(PARTS)} to"):
        harness.Bench(SAMPLES / "in.mp4", tmp_path, Look(), seconds=0.5, rounds=1)


def test_the_command_gets_the_look_of_the_bench(bench, tmp_path):
    assert bench.look_words == ("--look", str(tmp_path / "look.json"))
    assert Look.load(bench.look_words[1]) == LOOK
    photo = SAMPLES / "look.jpg"
    other = harness.Bench(bench.source, tmp_path, LOOK, seconds=0.5, rounds=1, photo=photo)
    assert other.look_words == ("--ref", str(photo))
