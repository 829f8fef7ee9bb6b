"""One seed's study and one small whole run, made once."""

from __future__ import annotations

import pytest

from planner.reproduce.manipulator.case import SeedStudy, study_seed
from planner.reproduce.manipulator.run import run_manipulator
from planner.reproduce.report import Report
from planner.setup.open import Query, make_query
from tests.reproduce.manipulator.small import SMALL


@pytest.fixture(scope="session")
def query() -> Query:
    return make_query(SMALL, near_start=False)


@pytest.fixture(scope="session")
def case(query: Query) -> SeedStudy:
    found = study_seed(query, SMALL)
    assert found is not None
    assert found.ways
    return found


@pytest.fixture(scope="session")
def small() -> Report:
    return run_manipulator(2, SMALL.nodes, "coal", seed=1)
