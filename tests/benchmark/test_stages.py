"""Times per stage, and the bottleneck. Nothing here is timed."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.benchmark import stages


def observed(*runs):
    stage_log = stages.StageLog()
    for items in runs:
        stage_log.start()
        for name, ms in items:
            stage_log(name, ms / 1000, ms / 2000)
    return stage_log


def test_100_frames_are_skipped_and_500_counted():
    items = [("faces", 1000)] * 100 + [("faces", ms) for ms in range(500)] + [("faces", 10**6)]
    row = observed(items, items).table(600)["faces"]
    assert row["mean_ms"] == row["p50_ms"] == pytest.approx(249.5)
    assert row["p95_ms"] == pytest.approx(474.05, abs=1)
    assert row["cpu_mean_ms"] == row["cpu_p50_ms"] == pytest.approx(249.5 / 2)


@given(st.integers(1, 700))
def test_a_short_video_still_has_frames_to_measure(frames):
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
def test_the_bottleneck_is_the_stage_that_others_wait_for(fills, waited_for):
    channels = dict(zip(("-> faces", "-> encode"), map(channel, fills), strict=True))
    assert stages.bottleneck(channels, STAGES) == waited_for
    assert stages.bottleneck({}, STAGES) == "decode"


def test_a_stage_on_its_own_thread_is_named_as_the_bottleneck():
    channels = {f"-> {name}": channel(0.1) for name in list(STAGES)[1:]} | {"-> faces": channel(1)}
    assert stages.bottleneck(channels, STAGES) == "faces"


def test_fills_are_medians_of_runs():
    runs = [{"-> faces": channel(fill)} for fill in (0.1, 0.9, 0.2)]
    assert stages.fills(runs) == {"-> faces": channel(0.2)}
