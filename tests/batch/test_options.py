"""What a process of its own is told to plan is what was asked for."""

from __future__ import annotations

import json
from pathlib import Path

from planner.batch.options import plain_options, plan_request
from planner.problem.request import PlanRequest


def test_a_request_survives_json() -> None:
    for request in (
        PlanRequest(),
        PlanRequest("panda", "shelf", srdf=Path("a.srdf"), motion_plan_request=Path("b.yaml"), beta=0.2, margin=0.01),
        PlanRequest(roadmap=Path("kept.npz"), min_manipulability=0.02, effort=3),
    ):
        assert plan_request(json.loads(json.dumps(plain_options(request)))) == request
