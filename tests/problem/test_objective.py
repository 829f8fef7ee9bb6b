"""The trade-off of eq. (finew) as one object."""

from __future__ import annotations

import numpy as np
import pytest

from planner.base.errors import OptionError
from planner.problem.request import Objective, PlanRequest, SweepRequest


def test_it_is_the_trade_off_of_the_paper() -> None:
    assert Objective(0.25).total(4.0, 8.0) == 0.75 * 4.0 + 0.25 * 8.0
    np.testing.assert_array_equal(Objective(1.0).total(np.array([3.0]), np.array([2.0])), [2.0])
    assert Objective(0.25, metric="workspace").at(0.5) == Objective(0.5, metric="workspace")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"beta": 1.1}, "beta must be less than or equal to 1, got 1.1."),
        ({"beta": float("nan")}, "beta must be a finite number"),
        ({"floor": -0.1}, "floor must be greater than or equal to 0"),
        ({"metric": "jonit"}, "metric must be 'joint' or 'workspace', got 'jonit'."),
        ({"charge": "path"}, "charge must be"),
        ({"manipulability_cost": "square"}, "manipulability cost must be"),
    ],
)
def test_what_is_no_objective_is_refused(wrong: dict, words: str) -> None:
    with pytest.raises(OptionError) as refusal:
        Objective(**wrong)
    assert words in str(refusal.value)


def test_a_request_holds_one() -> None:
    asked = {"metric": "workspace", "manipulability_cost": "linear", "charge": "nodes", "min_manipulability": 0.02}
    expected = Objective(0.3, "linear", "workspace", "nodes", 0.02)
    assert PlanRequest.from_options(beta=0.3, **asked).quality.objective == expected
    assert SweepRequest.from_options(**asked).quality.objective_at(0.3) == expected
