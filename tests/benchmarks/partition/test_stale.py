"""``benchmarks stale``: blocks that read old values, how old they are, and where the runs end."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.gabf.case import geometric_network
from benchmarks.partition import stale
from benchmarks.partition.stale import Row, StaleField, _measure, _run, _StaleRun, _when, bench_stale
from planner import gabf
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.gabf.partitioned.cut import Cut, bands
from planner.gabf.problem import Problem, reduce

LAW = gabf.SingularityFree()
NEVER = np.empty(0)


@pytest.fixture(scope="module")
def problem() -> Problem:
    return reduce(geometric_network(120, 6, np.random.default_rng(3)))


def walk(problem: Problem, delay: int, due: np.ndarray, taus: list[float]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """The boundary at every reading, and what the blocks are told of it."""
    cut = Cut.of(problem, bands(problem, 3), 3)
    y0 = problem.pack(gabf.overestimate(problem.network))
    field = StaleField(cut, LAW, y0, delay, due)
    was, told = [], []
    for tau in taus:
        state = field.state(tau, 1)
        was.append(state.y[cut.boundary])
        shared = np.empty(cut.boundary.size)
        for halo, values in zip(cut.halos, field._exchange([]), strict=True):
            shared[halo.received] = values
        told.append(shared)
        field.attempt(0.05, state.residual)
        field.accept()
    return was, told


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_blocks_are_told_the_boundary_of_so_many_steps_ago(problem: Problem, delay: int) -> None:
    was, told = walk(problem, delay, NEVER, [0.05 * k for k in range(6)])
    assert not np.array_equal(was[0], was[1])
    for k, values in enumerate(told):
        np.testing.assert_array_equal(values, was[max(0, k - delay)])


def test_blocks_are_told_the_boundary_at_the_readings_that_are_due(problem: Problem) -> None:
    was, told = walk(problem, 0, np.array([0.12, 0.3]), [0.0, 0.1, 0.12, 0.2, 0.3, 0.4])
    for values, at in zip(told, (0, 0, 2, 2, 4, 4), strict=True):
        np.testing.assert_array_equal(values, was[at])


def test_how_old_values_are_is_steps_or_shares_of_the_time() -> None:
    law = gabf.PrescribedTime()
    assert law.prescribed_time is not None
    assert _when(law, "4 steps")[0] == 4
    assert _when(law, "4 steps")[1].size == 0
    delay, due = _when(law, "0.1 T_p")
    assert delay == 0
    np.testing.assert_allclose(law.clock.time(due), 0.1 * law.prescribed_time * np.arange(1, 10), rtol=1e-9)


@pytest.mark.parametrize("start", ["above", "below"])
def test_values_that_are_old_by_steps_end_at_the_same_x_without_crossing_it(
    start: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stale, "NODES", 150)
    fresh, old = (_run(LAW, start, steps, np.random.default_rng(2)) for steps in ("0 steps", "4 steps"))
    for run in (fresh, old):
        assert run.settled
        assert run.error == 0.0
        assert not run.crossed
    assert fresh.tau_ratio is not None
    assert old.tau_ratio is not None
    assert old.tau_ratio > fresh.tau_ratio


@pytest.mark.parametrize("law", [gabf.Nominal(), gabf.SingularityFree()], ids=lambda law: law.name)
def test_rows_that_rest_on_old_values_move_again(law: gabf.Law, monkeypatch: pytest.MonkeyPatch) -> None:
    """None of them is retired, as it is where values are of the same instant."""
    monkeypatch.setattr(stale, "NODES", 250)
    for seed in range(3):
        run = _run(law, "below", "4 steps", np.random.default_rng(seed))
        assert run.settled
        assert run.error == 0.0


def test_values_that_are_told_too_seldom_leave_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Told once before T_p: whoever is two cuts from the source has heard nothing of it."""
    monkeypatch.setattr(stale, "NODES", 150)
    run = _run(gabf.PrescribedTime(), "above", "0.5 T_p", np.random.default_rng(2))
    assert not run.settled
    assert run.error > 0.01
    assert run.tau_ratio is None


def test_a_row_counts_its_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    runs = [
        _StaleRun(True, False, 0.0, 1.0, False),
        _StaleRun(True, True, 0.0, 3.0, True),
        _StaleRun(False, False, 0.25, None, False),
    ]
    left = iter(runs)
    monkeypatch.setattr(stale, "_run", lambda *_: next(left))
    blank = Row(LAW.name, "above", "4 steps", 3, 0, "software")
    (row,) = _measure(blank, QUIET)
    assert row == replace(blank, settled=2, crossed=1, error=0.25, tau_ratio=2.0, late=1)
    assert "| singularity-free | above | 4 steps | 3 | 2 | 1 | 0.25 | 2 | 1 |" in stale.to_markdown([row])


def test_every_law_start_and_staleness_is_a_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stale, "_measure", lambda blank, progress: [blank])
    rows = bench_stale(tmp_path, graphs=1).rows
    assert len({row.key for row in rows}) == len(rows)
    told = {"steps": len(stale.DELAYS), "T_p": len(stale.PERIODS)}
    counted = Counter((row.law, row.start, row.stale.split()[1]) for row in rows)
    expected = {
        (gabf.SingularityFree.name, start, unit): count for start in ("above", "below") for unit, count in told.items()
    }
    expected |= {(gabf.PrescribedTime.name, "above", unit): count for unit, count in told.items()}
    expected |= {(gabf.Nominal.name, start, "steps"): told["steps"] for start in ("above", "below")}
    assert counted == expected


def test_a_stop_leaves_the_rest(tmp_path: Path) -> None:
    found = bench_stale(tmp_path, graphs=1, progress=Progress(stop=lambda: True))
    assert (found.rows, found.complete) == ((), False)


@pytest.mark.parametrize("bad", [{"graphs": 0}, {"seed": -1}])
def test_numbers_that_make_no_sense_are_refused(bad: dict, tmp_path: Path) -> None:
    with pytest.raises(OptionError):
        bench_stale(tmp_path, **bad)
