"""A sweep, made once for the tests of its results and of its files."""

from __future__ import annotations

import pytest

from planner.problem.request import PlanRequest, SweepRequest
from planner.roadmap.storage import save_roadmap
from planner.tradeoff.sweep import Tradeoff, sweep
from tests.tradeoff.posts import asked


@pytest.fixture(scope="session")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Tradeoff:
    return sweep(asked(tmp_path_factory.mktemp("post")))


@pytest.fixture(scope="session")
def again(swept: Tradeoff, tmp_path_factory: pytest.TempPathFactory) -> SweepRequest | PlanRequest:
    """The same request on its roadmap as a file, so that nothing is grown."""
    path = tmp_path_factory.mktemp("roadmap") / "roadmap.npz"
    save_roadmap(swept.roadmap, path)
    return swept.request.with_options(roadmap=path)
