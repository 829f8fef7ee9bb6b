"""Reports, requests to stop, seconds per stage."""

from __future__ import annotations

import signal

import pytest

from planner.base.progress import QUIET, Progress, StopRequest, Stopwatch, rounded


def test_a_report_is_called_with_stage_done_and_total() -> None:
    seen: list[tuple[str, int, int]] = []
    progress = Progress(lambda *report: seen.append(report))
    progress("links", 3, 10)
    assert seen == [("links", 3, 10)]
    assert not progress.stopped


def test_quiet_reports_nothing_and_never_stops() -> None:
    QUIET("links", 1, 2)
    assert not QUIET.stopped


def test_stop_is_asked_every_time() -> None:
    answers = iter([False, True])
    progress = Progress(stop=lambda: next(answers))
    assert [progress.stopped, progress.stopped] == [False, True]


def test_a_renamed_report_keeps_the_request_to_stop() -> None:
    seen: list[str] = []
    outer = Progress(lambda stage, done, total: seen.append(stage), lambda: True)
    inner = outer.renamed(lambda stage, done, total: outer(f"inner {stage}", done, total))
    inner("links", 1, 2)
    assert seen == ["inner links"]
    assert inner.stopped


def test_ctrl_c_is_a_request_while_it_is_asked_for() -> None:
    before = signal.getsignal(signal.SIGINT)
    with StopRequest() as stop:
        assert not stop()
        signal.raise_signal(signal.SIGINT)
        assert stop()
    assert signal.getsignal(signal.SIGINT) is before


def test_a_stopwatch_sums_a_stage_that_is_entered_again() -> None:
    clock = Stopwatch()
    with clock("a"):
        pass
    first = clock.seconds["a"]
    with clock("a"):
        pass
    assert clock.seconds["a"] >= first >= 0.0
    with pytest.raises(ZeroDivisionError), clock("b"):
        raise ZeroDivisionError
    assert set(clock.seconds) == {"a", "b"}
    assert rounded({"a": 0.12345678}) == {"a": 0.123457}


def test_the_total_covers_stages_and_all_between(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [10.0]
    monkeypatch.setattr("planner.base.progress.time.perf_counter", lambda: now[0])
    clock = Stopwatch({"import": 2.0})
    now[0] += 0.5
    with clock("gabf"):
        now[0] += 3.0
    assert clock.record() == {"import": 2.0, "gabf": 3.0, "total": 5.5}
