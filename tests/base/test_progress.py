"""Reports, requests to stop, seconds per stage."""

import pytest

from planner.base.progress import QUIET, Progress, Stopwatch


def test_a_report_and_a_request_to_stop_pass_through() -> None:
    seen: list[tuple[str, int, int]] = []
    answers = iter([False, True])
    outer = Progress(lambda *report: seen.append(report), lambda: next(answers))
    inner = outer.with_report(lambda stage, done, total: outer(f"inner {stage}", done, total))
    inner("links", 3, 10)
    assert seen == [("inner links", 3, 10)]
    assert [inner.stopped, outer.stopped] == [False, True]
    QUIET("links", 1, 2)
    assert not QUIET.stopped


def test_a_stopwatch_sums_stages_and_its_total_covers_all_between(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [10.0]
    monkeypatch.setattr("planner.base.progress.time.perf_counter", lambda: now[0])
    clock = Stopwatch({"import": 2.0})
    now[0] += 0.5
    for _ in range(2):
        with clock("gabf"):
            now[0] += 1.5
    with pytest.raises(ZeroDivisionError), clock("b"):
        raise ZeroDivisionError
    assert clock.record() == {"import": 2.0, "gabf": 3.0, "b": 0.0, "total": 5.5}
