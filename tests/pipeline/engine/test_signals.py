"""Signals that stop a run, and delaying them until a step is done."""

import signal

import pytest
from makeup_video.pipeline.engine.signals import interrupted_later, stop_signals, undisturbed


def test_ctrl_c_within_a_step_counts_when_the_step_ends():
    done = []
    with pytest.raises(KeyboardInterrupt), interrupted_later():
        signal.raise_signal(signal.SIGINT)
        done.append(1)
    assert done == [1]
    with interrupted_later():
        done.append(2)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_signals_ignored_at_start_end_no_run():
    """`nohup` ignores SIGHUP, the signal of a closed terminal."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        assert signal.SIGHUP not in stop_signals()
        with interrupted_later():
            signal.raise_signal(signal.SIGHUP)
        with undisturbed():
            pass
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
        assert signal.SIGHUP in stop_signals()
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_handler_outside_python_stays(monkeypatch):
    monkeypatch.setattr(signal, "getsignal", lambda number: None)
    assert stop_signals() == []
