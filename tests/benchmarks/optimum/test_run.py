"""Plans are measured against the optimum, once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.optimum.run import bench_optimum
from planner.base.errors import OptionError

HULL = 3.6460  # rad: taut around the states in contact, bisected in 1001 columns; the other side takes 3.6626


def test_plans_are_rows_near_the_optimum_and_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.optimum.run.grid_optimum", lambda *asked: (np.array([[0], [HULL]]), 1e-4))
    asked = {"nodes": (60,), "efforts": (6,), "betas": (1.0,), "seeds": (0,), "arms": ("planar_2r",)}
    found = bench_optimum(tmp_path, **asked)  # type: ignore[arg-type]
    assert -0.05 < found.rows[0].gap < 3.0
    assert float(found.rows[0].curve.split()[-1]) == pytest.approx(found.rows[0].gap, abs=1e-3)
    assert bench_optimum(tmp_path, **asked).rows == found.rows  # type: ignore[arg-type]
    with pytest.raises(OptionError, match="arm 'x' not found"):
        bench_optimum(tmp_path, arms=("x",))
