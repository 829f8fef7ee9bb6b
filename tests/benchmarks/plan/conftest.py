"""Problems and their rows, made once."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.plan.run import bench_plan
from tests.batch.posts import PLAIN


@pytest.fixture(scope="session")
def out(problems: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("bench")
    assert bench_plan(problems, place, PLAIN, seeds=(0, 1)).complete
    return place
