"""Sound that keeps step with the clock of the pictures, whatever the sound card's clock does."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.live.sound import RATE, LiveSound, SoundBlock, SoundTap
from makeup_video.pipeline.live.steady_sound import SteadySound

ZERO = 1234.5
CLAP = 0.9


def card(seconds, claps, *, faster=0.0, late_ms=0.0, block=480, lost=()):
    """Yield the blocks of a sound card, timed by their arrival.

    claps: seconds at which one sample is loud.  faster: the share by which its clock is fast.
    late_ms: blocks arrive up to this much late.  lost: numbers of blocks that never arrive.
    """
    random = np.random.default_rng(3)
    rate = RATE * (1 + faster)
    loud = np.array([round(clap * rate) for clap in claps], int)
    for number in range(int(seconds * rate / block)):
        first = number * block
        samples = np.zeros((1, block), np.float32)
        samples[0, loud[(loud >= first) & (loud < first + block)] - first] = CLAP
        taken = ZERO + first / rate
        if number not in lost:
            yield SoundBlock(samples, taken + random.random() * late_ms / 1000)


def heard(blocks, steady=None):
    """Seconds at which the claps stand in the corrected sound."""
    steady = steady or SteadySound(1, ZERO)
    out = np.concatenate([part[0] for block in blocks for part in steady.add(block)])
    loud = np.flatnonzero(out > CLAP / 4)
    starts = loud[np.diff(loud, prepend=-RATE) > RATE / 100]
    return starts / RATE


@pytest.mark.parametrize(("faster", "late_ms"), [(2e-4, 30.0), (-2e-4, 30.0), (0.0, 0.0)])
def test_ten_minutes_drift_by_less_than_five_milliseconds(faster, late_ms):
    """Uncorrected, a clock that is off by 0.02 % drifts by 120 ms."""
    claps = np.arange(5, 600, 7.3)
    got = heard(card(600, claps, faster=faster, late_ms=late_ms, block=4800))
    assert len(got) == len(claps)
    assert np.abs(got - claps).max() < 0.005


def test_lost_samples_are_made_good_within_seconds():
    claps = np.arange(5, 60, 1.1)
    got = heard(card(60, claps, late_ms=5, lost=(2001, 2002, 2003)))  # 30 ms, 20 s from the start
    assert len(got) == len(claps)
    late = np.abs(got - claps)
    assert late[claps < 20].max() < 0.005 and late[claps > 32].max() < 0.005
    assert late.max() < 0.035


@pytest.mark.parametrize("lost_ms", [100, 300, 600, 900])
def test_a_loss_of_samples_is_made_good_after_a_second(lost_ms):
    claps = np.arange(5, 40, 0.7)
    got = heard(card(40, claps, late_ms=5, lost=range(2000, 2000 + lost_ms // 10)))  # from 20 s on
    after = claps[claps > 21.3 + lost_ms / 1000]
    assert all(np.abs(got - clap).min() < 0.02 for clap in after)


@pytest.mark.parametrize("held_ms", [100, 300, 900])
def test_blocks_that_arrive_late_and_at_once_lose_nothing(held_ms):
    """As if the thread that reads them had not run for a while."""
    blocks = []
    for number, block in enumerate(card(30, np.arange(2, 29, 1.1))):
        length = block.samples.shape[1] / RATE
        waits = max(0.0, 20 + held_ms / 1000 - (number + 1) * length) if number >= 2000 else 0.0
        blocks.append(SoundBlock(block.samples, block.begins_seconds + waits))
    steady = SteadySound(1, ZERO)
    got = heard(blocks, steady)
    assert np.abs(got - np.arange(2, 29, 1.1)).max() < 0.02
    assert steady.silent < 0.01 * RATE


@pytest.mark.parametrize(("late_ms", "for_ms"), [(50, 300), (80, 300), (150, 500), (100, 900)])
def test_blocks_that_are_late_for_a_while_lose_nothing(late_ms, for_ms):
    """As on a machine that is busy in every other second."""
    blocks = []
    for number, block in enumerate(card(30, np.arange(2, 29, 1.1))):
        late = late_ms / 1000 if number % 200 < for_ms / 10 and number > 200 else 0.0
        blocks.append(SoundBlock(block.samples, block.begins_seconds + late))
    steady = SteadySound(1, ZERO)
    assert np.abs(heard(blocks, steady) - np.arange(2, 29, 1.1)).max() < 0.02
    assert steady.silent == 0


def test_a_hole_is_filled_with_silence_of_its_length():
    blocks = list(card(20, [2, 18]))
    steady = SteadySound(1, ZERO)
    got = heard(blocks[:500] + blocks[900:], steady)  # four seconds are missing
    assert got == pytest.approx([2, 18], abs=0.003)
    assert steady.silent / RATE == pytest.approx(4, abs=0.01)


def test_sound_before_the_first_picture_is_left_out():
    steady = SteadySound(1, ZERO + 3)
    assert heard(card(10, [1, 5]), steady) == pytest.approx([2], abs=0.003)


def test_sound_that_begins_late_begins_late():
    blocks = [one for one in card(10, [1, 5]) if one.begins_seconds > ZERO + 2]
    assert heard(blocks) == pytest.approx([5], abs=0.003)


def test_exact_times_hold_at_once():
    blocks = list(card(4, [1, 3]))
    moved = [SoundBlock(b.samples, b.begins_seconds + 0.3, True) for b in blocks[200:]]
    exact = [SoundBlock(b.samples, b.begins_seconds, True) for b in blocks[:200]]
    assert heard(exact + moved) == pytest.approx([1, 3.3], abs=0.0005)


def test_a_source_that_falls_silent_is_padded_and_fits_again():
    blocks = list(card(20, [2, 18]))
    steady = SteadySound(1, ZERO)
    out = [part for block in blocks[:500] for part in steady.add(block)]
    for seconds in np.arange(5, 15, 0.033):
        out += steady.pad(ZERO + seconds)
    assert steady.count / RATE == pytest.approx(14.6, abs=0.4)
    out += [part for block in blocks[1500:] for part in steady.add(block)]
    loud = np.flatnonzero(np.concatenate(out, axis=1)[0] > CLAP / 4) / RATE
    assert loud[[0, -1]] == pytest.approx([2, 18], abs=0.003)


@settings(deadline=None)
@given(
    st.lists(st.tuples(st.integers(1, 2000), st.floats(-3, 3)), min_size=1, max_size=40),
    st.integers(1, 2),
)
def test_whatever_comes_the_count_is_what_went_out(pieces, channels):
    steady, at, out = SteadySound(channels, ZERO), ZERO, 0
    for count, shift in pieces:
        for got in steady.add(SoundBlock(np.ones((channels, count), np.float32), at + shift)):
            assert got.shape[0] == channels and got.dtype == np.float32 and np.isfinite(got).all()
            assert got.shape[1] <= max(RATE, 2 * count)
            out += got.shape[1]
        at += count / RATE
    assert steady.count == out <= 8 * RATE * len(pieces)


def test_an_hour_without_a_camera_takes_no_more_memory():
    steady = SteadySound(2, ZERO)
    block = SoundBlock(np.ones((2, 480), np.float32), ZERO + 3600, True)
    parts = [part.shape[1] for part in steady.add(block)]
    assert max(parts) <= RATE and sum(parts) == 3600 * RATE + 480
    assert max(part.shape[1] for part in steady.pad(ZERO + 7200)) <= RATE
    assert steady.count / RATE == pytest.approx(7200, abs=0.5)


def test_a_tap_that_is_not_read_keeps_the_last_seconds():
    tap = SoundTap("card", 1)
    for block in card(30, []):
        tap.put(block)
    kept = tap.take()
    assert 9.9 < kept[-1].begins_seconds - kept[0].begins_seconds <= 10
    assert tap.take() == []


class Card:
    name, channels, closed = "card", 1, False

    def __init__(self, blocks):
        self._blocks = blocks

    def blocks(self):
        return self._blocks

    def close(self):
        self.closed = True


def test_a_tap_that_is_closed_is_forgotten():
    sound = LiveSound(Card(iter([])), pytest.fail)
    for _ in range(5):
        sound.tap().close()
    assert len(sound._taps) <= 1


@pytest.mark.parametrize("while_tapped", [False, True])
def test_a_microphone_is_closed_with_its_last_tap(while_tapped):
    source = Card(iter([]))
    sound = LiveSound(source, pytest.fail, while_tapped=while_tapped)
    first, second = sound.tap(), sound.tap()
    first.close()
    assert not source.closed and not sound.is_over
    second.close()
    assert source.closed == sound.is_over == while_tapped


def test_every_tap_gets_every_block():
    blocks = list(card(1, []))
    source = Card(iter(blocks))
    sound = LiveSound(source, pytest.fail)
    taps = [sound.tap(), sound.tap()]
    sound.start()
    sound.close()
    assert source.closed
    assert [tap.take() for tap in taps] == [blocks, blocks]
