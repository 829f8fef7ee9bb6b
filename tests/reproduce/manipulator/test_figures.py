"""Which paths go into which picture of Section 4.2."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planner.figures import figure as figures
from planner.reproduce.manipulator.case import BETAS, RRT, SHORTENED, SeedStudy
from planner.reproduce.manipulator.run import manipulator_pictures
from planner.reproduce.manipulator.verdicts import PAPER_COSTS
from planner.setup.open import Query
from tests.reproduce.manipulator.test_run import ideal


def test_one_path_per_group_and_costs_of_every_seed(monkeypatch: pytest.MonkeyPatch, query: Query) -> None:
    drawn: dict[str, Any] = {}
    for name in ("tool_paths", "path_profiles", "beta_costs"):
        monkeypatch.setattr(figures, name, lambda *arguments, name=name: drawn.setdefault(name, arguments))
    cases: list[SeedStudy] = [ideal(0), ideal(1)]
    assert len(manipulator_pictures(query, cases[0], cases)) == 3
    paths = drawn["tool_paths"][2]
    assert list(paths) == ["β = 0, 0.3", "β = 0.5, 0.7, 1", RRT]
    np.testing.assert_array_equal(paths[RRT], cases[0].ways[RRT].q)
    betas, ours, others, printed = drawn["beta_costs"]
    assert betas == BETAS
    assert ours[0].shape == (2, len(BETAS))
    np.testing.assert_allclose(ours[0][0], printed[0])
    np.testing.assert_allclose(np.array(printed).T, [PAPER_COSTS[beta] for beta in BETAS])
    assert set(others) == {RRT, SHORTENED}
