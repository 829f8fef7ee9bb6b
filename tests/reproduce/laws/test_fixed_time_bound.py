"""The printed bound of the fixed-time law against numerics."""

from __future__ import annotations

import pytest

from planner.reproduce.laws.fixed_time_bound import EXTREME, bound_verdicts, paper_times, scalar_time


def test_the_printed_bound_fails_where_numerics_says() -> None:
    scalars = paper_times()
    by_label = {scalar.label: scalar for scalar in scalars}
    worst = by_label["3/5, 15/7"]
    assert worst.printed == pytest.approx(2.375)
    assert worst.measured == pytest.approx(2.799, abs=1e-3)
    printed, theorem, corrected, sharp = bound_verdicts(scalars, scalar_time(*EXTREME))
    assert 0 < printed.confirmed < printed.of == 16
    assert "3/5, 15/7: 2.375 < 2.799" in printed.note
    assert not theorem.holds
    assert corrected.holds
    assert sharp.holds
