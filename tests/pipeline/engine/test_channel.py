"""Channels between threads: order, capacity, closing and cancelling."""

import threading
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.engine.channel import Channel, ChannelClosed, NewestChannel


@given(items=st.lists(st.integers(), max_size=60), capacity=st.integers(1, 8))
@settings(deadline=None)
def test_every_item_arrives_once_in_order_and_few_wait(items, capacity):
    channel, fills = Channel("test", capacity), []

    def send():
        for item in items:
            channel.send(item)
            fills.append(channel.fill)
        channel.close()

    sender = threading.Thread(target=send)
    sender.start()
    assert list(channel) == items
    sender.join()
    assert all(fill <= capacity for fill in fills)
    assert 0 <= channel.mean_fill <= capacity


@given(items=st.lists(st.integers(), max_size=30), most=st.integers(1, 8))
def test_batches_hold_what_waits_in_order(items, most):
    channel = Channel("test", 30)
    for item in items:
        channel.send(item)
    channel.close()
    batches = list(channel.batches(most))
    assert [item for batch in batches for item in batch] == items
    assert all(len(batch) == most for batch in batches[:-1])
    assert all(0 < len(batch) <= most for batch in batches)


def test_a_full_channel_makes_the_sender_wait():
    channel = Channel("test", 2)
    channel.send(1)
    channel.send(2)
    sender = threading.Thread(target=channel.send, args=(3,))
    sender.start()
    time.sleep(0.05)
    assert sender.is_alive() and channel.fill == 2
    assert next(iter(channel)) == 1
    sender.join(5)
    assert not sender.is_alive()


def test_the_mean_fill_of_a_channel_that_is_always_full():
    channel = Channel("test", 1)
    channel.send(1)  # finds the channel empty
    sender = threading.Thread(target=channel.send, args=(2,))
    sender.start()
    time.sleep(0.05)
    assert next(iter(channel)) == 1
    sender.join(5)
    assert channel.mean_fill == 0.5


def test_close_lets_the_receiver_drain():
    channel = Channel("test", 4)
    channel.send("a")
    channel.send("b")
    channel.close()
    assert list(channel) == ["a", "b"]
    with pytest.raises(ChannelClosed):
        channel.send("c")


@pytest.mark.parametrize("waiting", ["sender", "receiver"])
def test_cancel_wakes_both_ends_and_drops_waiting_items(waiting):
    channel, outcome = Channel("test", 1), []
    if waiting == "sender":
        channel.send(1)

    def wait():
        try:
            outcome.append(channel.send(2) if waiting == "sender" else list(channel))
        except ChannelClosed:
            outcome.append("closed")

    thread = threading.Thread(target=wait)
    thread.start()
    time.sleep(0.05)
    channel.cancel()
    thread.join(5)
    assert outcome == ["closed" if waiting == "sender" else []]
    assert channel.fill == 0


def test_mean_fill_shows_which_end_is_slow():
    slow_receiver, slow_sender = Channel("a", 3), Channel("b", 3)
    for item in range(3):
        slow_receiver.send(item)
        slow_sender.send(item)
        next(iter(slow_sender))
    assert slow_receiver.mean_fill == 1.0  # the three calls of send found 0, 1 and 2 items waiting
    assert slow_sender.mean_fill == 0.0


@pytest.mark.parametrize("capacity", [0, -1])
def test_a_channel_without_room_is_refused(capacity):
    with pytest.raises(ValueError, match="at least 1"):
        Channel("test", capacity)


@given(items=st.lists(st.integers(), max_size=60), capacity=st.integers(1, 8))
def test_the_newest_channel_never_waits_and_keeps_the_last(items, capacity):
    channel = NewestChannel("test", capacity)
    for item in items:
        channel.send(item)
        assert channel.fill <= capacity
    channel.close()
    assert list(channel) == items[-capacity:]
    assert channel.dropped == max(0, len(items) - capacity)
    with pytest.raises(ChannelClosed):
        channel.send(0)


def test_what_comes_after_the_end_drops_nothing_that_waits():
    channel = NewestChannel("test")
    channel.send("a")
    channel.close()
    with pytest.raises(ChannelClosed):
        channel.send("b")
    assert list(channel) == ["a"] and channel.dropped == 0
