"""Which runs go into which picture of Section 4.1."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planner import gabf
from planner.figures import laws as law_figures
from planner.reproduce.laws.cases import FREE, PRESCRIBED, Measurement, Trace
from planner.reproduce.laws.fixed_time_bound import scalar_time
from planner.reproduce.laws.run import law_pictures
from tests.reproduce.laws.test_run import ideal


def test_every_picture_gets_its_own_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: dict[str, Any] = {}
    for name in ("node_histories", "exponent_summary", "fixed_time_bounds", "near_deadline"):
        monkeypatch.setattr(
            law_figures, name, lambda *arguments, name=name: drawn.setdefault(name, []).append(arguments)
        )
    t = np.array([0.0, 1.0])
    traces = [Trace(case, 4, t, t, t) for case in (*PRESCRIBED, *FREE)]
    runs: list[Measurement] = [ideal(0, case) for case in (*PRESCRIBED, *FREE)]
    scalar = scalar_time((1, 3), (5, 3))
    names = law_pictures(runs, traces, [], [scalar])
    assert "laws_near_deadline.png" not in names
    assert len(names) == 5
    first, above, below = (rows for rows, _, _ in drawn["node_histories"])
    assert len(first[0][1]) == len(PRESCRIBED)
    assert [title for title, _ in above] == [title for title, _ in below]
    ((summary,),) = drawn["exponent_summary"]
    free = [case for case in FREE if isinstance(case.law, gabf.SingularityFree)]
    assert sum(len(cells) for cells in summary.values()) == len(free)
    assert set(summary) == {"above", "below"}
    ((labels, lines),) = drawn["fixed_time_bounds"]
    assert labels == ["1/3, 5/3"]
    assert lines["sharp"] == [scalar.sharp]
