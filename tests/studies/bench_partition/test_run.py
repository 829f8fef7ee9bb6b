"""``planner bench partition`` and ``stale``: the same x from every method, rows that are kept, and old values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.studies.bench_partition import run as module
from planner.studies.bench_partition.case import HERE, WHOLE
from planner.studies.bench_partition.run import bench_partition
from planner.studies.bench_partition.stale import _run, bench_stale


def test_every_method_has_a_row_with_the_same_x(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = bench_partition(tmp_path, arcs=(3000,))
    of = {row.method: row for row in found.rows}
    assert of[HERE].x_sha256 == of[WHOLE].x_sha256
    assert of[WHOLE].settled
    assert (of[HERE].told or 0) > (of[HERE].boundary or 0) > 0
    assert "one process" in found.report
    monkeypatch.setattr(module, "_measure", lambda *_, **__: [])  # nothing is measured again
    assert bench_partition(tmp_path, arcs=(3000,)).rows == found.rows


@pytest.mark.parametrize("bad", [{"arcs": (5,)}, {"blocks": 1}, {"steps": 0}, {"seed": -1}])
def test_numbers_that_make_no_sense_are_refused(bad: dict, tmp_path: Path) -> None:
    with pytest.raises(OptionError):
        bench_partition(tmp_path, **bad)


@pytest.mark.parametrize("start", ["above", "below"])
def test_values_that_are_old_by_steps_end_at_the_same_x_without_crossing_it(start: str) -> None:
    fresh = _run(gabf.SingularityFree(), start, "0 steps", np.random.default_rng(2))
    old = _run(gabf.SingularityFree(), start, "4 steps", np.random.default_rng(2))
    for run in (fresh, old):
        assert run.settled
        assert not run.crossed
    assert fresh.tau_ratio is not None
    assert old.tau_ratio is not None
    assert old.tau_ratio > fresh.tau_ratio


def test_a_stop_leaves_the_rest(tmp_path: Path) -> None:
    found = bench_stale(tmp_path, graphs=1, progress=Progress(stop=lambda: True))
    assert (found.rows, found.complete) == ((), False)
    with pytest.raises(OptionError):
        bench_stale(tmp_path, graphs=0)
