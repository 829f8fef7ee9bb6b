"""Files of several tests of commands."""

from pathlib import Path

import pytest

from planner.planning.plan import plan
from planner.problem.request import PlanRequest, TimingRequest


@pytest.fixture(scope="session")
def timed_plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a plan and its trajectory."""
    folder = tmp_path_factory.mktemp("made")
    request = PlanRequest.from_options(robot="planar_2r", scene="empty", start="q:-1,0.5", goal="q:1,0.9", nodes=60)
    plan(request=request, timing=TimingRequest()).save_without_page(folder)
    return folder
