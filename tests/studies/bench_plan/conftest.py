"""Problems and their rows, made once."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.studies.bench_plan.run import bench_plan
from tests.studies.bench_plan.posts import PLAIN, write_problem


@pytest.fixture(scope="session")
def problems(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One that is solved, and one whose goal is out of limits."""
    folder = tmp_path_factory.mktemp("problems")
    write_problem(folder / "posts", "0001", (-1.0, 0.8), (1.0, -0.8))
    write_problem(folder / "far", "0001", (-1.0, 0.8), (1.0, -2.99))
    return folder


@pytest.fixture(scope="session")
def out(problems: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("bench")
    assert bench_plan(problems, place, PLAIN, seeds=(0, 1)).complete
    return place
