"""One graph's study and one small whole run, made once."""

from __future__ import annotations

import pytest

from planner.studies.learning import run as experiment
from planner.studies.learning import scan as learning_scan
from planner.studies.learning import study as learning_study
from planner.studies.learning.run import run_learning, study_graph
from planner.studies.learning.study import GraphStudy
from planner.studies.report import Report
from tests.studies.learning.small import ROBOT


@pytest.fixture(scope="session")
def report() -> Report:
    """A whole run, small: 3 graphs, one of them in turn, a scan of four trials, one roadmap."""
    patch = pytest.MonkeyPatch()
    patch.setattr(learning_study, "IN_TURN", 1)
    patch.setattr(learning_scan, "GRAPHS", 2)
    patch.setattr(learning_scan, "ALPHAS", (5.0,))
    patch.setattr(learning_scan, "BETAS", (0.001, 3.0))
    for module in (learning_scan, experiment):
        patch.setattr(module, "TRIALS", 4)
    try:
        return run_learning(graphs=3, iterations=6, seed=0, robot=ROBOT)
    finally:
        patch.undo()


@pytest.fixture(scope="session")
def study() -> GraphStudy:
    return study_graph(12, iterations=6, seed=0)
