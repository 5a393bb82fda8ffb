"""The cost of several looks of one video. Nothing here is timed."""

import pytest
from makeup_video.benchmark import harness, many
from makeup_video.benchmark.tables import more_tables
from makeup_video.pipeline import Look, product
from media import decoded
from people import SAMPLES


def test_one_run_and_separate_runs_paint_all_looks(tmp_path):
    look = Look(lips=product((150, 30, 70), "satin"))
    bench = harness.Bench(SAMPLES / "in.mp4", tmp_path, look, seconds=0.5, rounds=1)
    video = bench.video(144)
    found = many.by_looks(bench, video, 3)
    assert list(found["runs"]) == ["shared", "one", "many", "separate"]
    for number in range(3):
        assert len(decoded(tmp_path / f"look{number}.mp4")) == video.frames
    assert found["further_by_own"] == pytest.approx(found["further_cpu_ms"] / found["own_cpu_ms"])
    costs = {name: run["cpu_ms_per_frame"] for name, run in found["runs"].items()}
    assert found["own_cpu_ms"] == pytest.approx(costs["one"] - costs["shared"])
    assert found["further_cpu_ms"] == pytest.approx((costs["many"] - costs["one"]) / 2)
    memory = found["memory_mb"]
    assert memory["further"] == pytest.approx((memory["many"] - memory["one"]) / 2)
    ((title, head, rows),) = more_tables({"looks": {"size": "144p", **found}})
    assert title == "3 looks of one video, 144p" and {len(row) for row in rows} == {len(head)}
