"""The grid's optimum against an exact one."""

from __future__ import annotations

import pytest

from benchmarks.optimum import grid
from benchmarks.optimum.arms import TWO_JOINTS
from benchmarks.optimum.grid import grid_optimum, path_cost
from planner.objective.scale import CostScale

SCALE = CostScale(0.02, 0.2, 1.0, 1.0, 0.01)
HULL = 3.6460  # rad: taut around the states in contact, bisected in 1001 columns; the other side takes 3.6626


def test_the_grid_finds_the_taut_path(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(grid._HALVINGS, 2, 5)  # enough for 0.1 %
    path, error = grid_optimum(TWO_JOINTS, 1.0, SCALE)
    assert path_cost(TWO_JOINTS, 1.0, SCALE, path) == pytest.approx(HULL, rel=1e-3)
    assert error < 1e-3
