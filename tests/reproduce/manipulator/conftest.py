"""One seed's study and one small whole run, made once."""

import pytest

from planner.problem.request import SweepRequest
from planner.query.query import Query
from reproduce.manipulator.case import SeedStudy, query_of, study_seed
from reproduce.manipulator.run import run_manipulator
from reproduce.report import Report

SMALL = SweepRequest.from_options(nodes=80, seed=1)


@pytest.fixture(scope="session")
def query() -> Query:
    return query_of(SMALL)


@pytest.fixture(scope="session")
def case() -> SeedStudy:
    found = study_seed(0, SMALL)
    assert found.ways
    return found


@pytest.fixture(scope="session")
def small() -> Report:
    return run_manipulator(2, SMALL.quality.nodes, seed=1)
