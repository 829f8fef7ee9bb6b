"""SIGINT handlers are there while they are meant to be, and in the main thread only."""

from __future__ import annotations

import contextlib
import signal
import threading

import pytest

from planner.base import interrupts
from planner.base.interrupts import leaving_on_interrupt


def test_inside_ctrl_c_leaves_and_afterwards_it_is_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    left: list[str] = []
    monkeypatch.setattr(interrupts, "leave", left.append)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with contextlib.suppress(ValueError), leaving_on_interrupt("gone."):
            signal.raise_signal(signal.SIGINT)
            raise ValueError  # as work may end
        assert left == ["gone."]
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)


def test_another_thread_changes_no_handler() -> None:
    seen = []

    def work() -> None:
        with leaving_on_interrupt("gone."):
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [signal.getsignal(signal.SIGINT)]
