"""SIGINT leads where it is meant to while that is meant, and as before afterwards."""

import contextlib
import signal

import pytest

from planner.base import interrupts
from planner.base.interrupts import StopRequest, exit_on_interrupt


def test_inside_ctrl_c_leaves_and_afterwards_it_is_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    left: list[str] = []
    monkeypatch.setattr(interrupts, "leave", left.append)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with contextlib.suppress(ValueError), exit_on_interrupt("gone."):
            signal.raise_signal(signal.SIGINT)
            raise ValueError  # as work may end
        assert left == ["gone."]
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)


def test_ctrl_c_is_a_request_once_somebody_asks_and_the_third_leaves(monkeypatch: pytest.MonkeyPatch) -> None:
    left: list[str] = []
    monkeypatch.setattr(interrupts, "leave", left.append)
    monkeypatch.setattr(interrupts, "_SAVING", ("a", "b", "c"))
    before = signal.getsignal(signal.SIGINT)
    with StopRequest() as stop:
        assert not stop()
        for _ in range(3):
            assert not left
            signal.raise_signal(signal.SIGINT)
            assert stop()
    assert left == ["left without saving."]
    assert signal.getsignal(signal.SIGINT) is before
    assert not interrupts.stop_requests
