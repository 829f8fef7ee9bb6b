"""``benchmarks tasks``: rows of small tasks, their scenes, and the greedy chain that is never cheaper."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.results import read_rows
from benchmarks.tasks.run import Row, bench_tasks, greedy_cost
from benchmarks.tasks.scenes import KINDS, seeded_scene
from planner.base.errors import OptionError
from tests.tasks.cases import small


def test_rows_say_what_was_solved_and_what_it_cost(tmp_path: Path) -> None:
    found = bench_tasks(tmp_path, scenes=1, nodes=100, kinds=("table",))
    (row,) = read_rows(tmp_path / "tasks.csv", Row, "python -m benchmarks tasks")
    assert (row.outcome, row.segments_bad, row.proven) == ("solved", 0, True)
    assert row.cost is not None
    assert row.stuck or (row.greedy_cost or 0.0) >= row.cost * (1 - 1e-9)
    assert "| table | 1 | 1 | 1 of 1 | 0 | 0 |" in found.report
    assert (tmp_path / "tasks.md").read_text() == found.report


@pytest.mark.parametrize("beta", [0.0, 0.5, 1.0])
def test_greedy_is_never_cheaper_than_all_at_once(beta: float) -> None:
    cost = small().plan(beta=beta).cost
    greedy = greedy_cost(small(), beta)
    assert cost is not None
    assert greedy is not None
    assert greedy >= cost.total * (1 - 1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_makes_the_same_scene(kind: str) -> None:
    one, two, other = (seeded_scene(kind, 3, seed) for seed in (0, 0, 1))
    assert one.identity == two.identity != other.identity
    assert len({item.name for item in one.obstacles}) == len(one.obstacles)
    assert all(np.isfinite(item.placement).all() for item in one.obstacles)


def test_numbers_out_of_range_are_refused(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="at least 1 scene"):
        bench_tasks(tmp_path, scenes=0)
