"""What every method of the tables is asked."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.tables.methods import KEPT, PATH_ONLY, asked_by
from planner.problem.request import PlanRequest

PLAIN = PlanRequest("iiwa14", "gcs", nodes=30, beta=0.7, collision="coal", seed=4)


@pytest.mark.parametrize("kept", [True, False])
def test_a_method_differs_from_the_plain_request_in_what_its_name_says(kept: bool) -> None:
    found = asked_by(PLAIN, (0.0, 0.25, 1.0), kept)
    expected = {
        PATH_ONLY: replace(PLAIN, path_only=True, nodes=PlanRequest().nodes),  # no roadmap
        "beta 0": replace(PLAIN, beta=0.0),
        "beta 0.25": replace(PLAIN, beta=0.25),
        "beta 1": replace(PLAIN, beta=1.0),
    }
    assert found == expected | ({KEPT: replace(PLAIN, beta=1.0)} if kept else {})
