"""The memory of a track ends after a long absence, and no sooner."""

from typing import NamedTuple

import pytest
from makeup_video.pipeline.faces.track_memory import TrackMemory


class Reading(NamedTuple):
    last_seconds: float


@pytest.fixture
def memory():
    return TrackMemory(0.5)


def test_a_track_is_remembered_for_as_long_as_the_gap(memory):
    memory[7], memory[8] = Reading(1.0), Reading(1.25)
    memory.forget(1.5)
    assert set(memory) == {7, 8}
    memory.forget(1.625)
    assert set(memory) == {8}
    memory.forget(1.75)
    assert set(memory) == {8}
    memory.forget(2.0)
    assert not memory


def test_a_track_that_is_seen_again_is_kept(memory):
    memory[7] = Reading(1.0)
    memory[7] = Reading(1.4)
    memory.forget(1.8)
    assert memory[7].last_seconds == 1.4


def test_a_clock_that_jumps_back_leaves_nothing_for_ever(memory):
    memory[7], memory[8] = Reading(100.0), Reading(0.25)
    memory.forget(0.0)
    assert set(memory) == {8}


def test_keys_may_name_a_region(memory):
    memory[7, "lips"], memory[7, "eye 0"] = Reading(1.0), Reading(3.0)
    memory.forget(3.0)
    assert set(memory) == {(7, "eye 0")}


@pytest.mark.parametrize("gap", [0.0, -1.0, float("nan")])
def test_a_gap_of_no_time_is_refused(gap):
    with pytest.raises(ValueError, match="gap_seconds must be more than 0"):
        TrackMemory(gap)
