"""The trade-off of eq. (finew) as one object."""

import numpy as np

from planner.problem.request import Objective, PlanRequest, SweepRequest


def test_it_is_the_trade_off_of_the_paper() -> None:
    assert Objective(0.25).total(4.0, 8.0) == 0.75 * 4.0 + 0.25 * 8.0
    np.testing.assert_array_equal(Objective(1.0).total(np.array([3.0]), np.array([2.0])), [2.0])
    assert Objective(0.25, metric="workspace").at(0.5) == Objective(0.5, metric="workspace")


def test_a_request_holds_one() -> None:
    asked = {
        "metric": "workspace",
        "manipulability_cost": "linear",
        "cost_integration": "nodes",
        "min_manipulability": 0.02,
    }
    expected = Objective(0.3, "linear", "workspace", "nodes", 0.02)
    assert PlanRequest.from_options(beta=0.3, **asked).quality.objective == expected
    assert SweepRequest.from_options(**asked).quality.objective_at(0.3) == expected
