"""A plan and a sweep on the same roadmap, made once."""

from __future__ import annotations

import pytest

from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.request import PlanRequest
from planner.roadmap.storage import save_roadmap
from planner.tradeoff.result import Tradeoff
from planner.tradeoff.sweep import add_alternatives, sweep

TASK = PlanRequest.from_options(robot="planar_2r", scene="empty", start="q:-2,1.5", goal="q:2,-2", nodes=150, seed=4)


@pytest.fixture(scope="session")
def made() -> Plan:
    return add_alternatives(plan(request=TASK, timing=None))


@pytest.fixture(scope="session")
def tradeoff(made: Plan, tmp_path_factory: pytest.TempPathFactory) -> Tradeoff:
    path = tmp_path_factory.mktemp("roadmap") / "roadmap.npz"
    save_roadmap(made.roadmap, path)
    return sweep(request=TASK.with_options(roadmap=path))
