"""One graph's study and one small whole run, made once."""

from __future__ import annotations

import pytest

from planner.reproduce.learning import run as experiment
from planner.reproduce.learning import scan as learning_scan
from planner.reproduce.learning import study as learning_study
from planner.reproduce.learning.run import run_learning, study_graph
from planner.reproduce.learning.study import GraphStudy
from planner.reproduce.report import Report
from tests.reproduce.learning.small import ROBOT


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
