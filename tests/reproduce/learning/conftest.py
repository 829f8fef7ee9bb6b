"""One graph's study and one small whole run, made once."""

import pytest

from reproduce.learning import study as learning_study
from reproduce.learning.run import run_learning
from reproduce.learning.study import GraphStudy, study_graph
from reproduce.report import Report


@pytest.fixture(scope="session")
def report() -> Report:
    """A whole run, small: 3 graphs, one of them in turn."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(learning_study, "IN_TURN", 1)
        return run_learning(graphs=3, iterations=6, seed=0)


@pytest.fixture(scope="session")
def study() -> GraphStudy:
    return study_graph(12, iterations=6, seed=0)
