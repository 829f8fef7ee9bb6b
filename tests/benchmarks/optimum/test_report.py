"""The fit of gaps over rounds, and the report's aims."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.optimum.report import Row, aims, fitted_power, to_markdown

CURVE = " ".join(["9"] + [str(2.0 * k**-0.7) for k in range(1, 12)])
ROW = Row("planar_2r", 1.0, 1000, 11, 0, "", 1.0, 1.0, 0.01, 0.4, 2, CURVE)


def test_a_power_is_fitted_to_gaps() -> None:
    assert fitted_power([ROW, replace(ROW, seed=1)]) == pytest.approx((2.0, 0.7))
    assert fitted_power([replace(ROW, curve="3 2 1")]) is None


def test_an_aim_counts_the_plans_within_it() -> None:
    rows = [ROW, replace(ROW, seed=1, gap=1.2)]
    assert (aims(rows)[0].confirmed, aims(rows)[0].of) == (1, 2)
    assert "| planar_2r | 1 | 1000 | 11 | 2 |" in to_markdown(rows)
