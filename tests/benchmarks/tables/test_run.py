"""``benchmarks tables``: every task is planned by every method, and published numbers stand beside as typed."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.tables.run import bench_tables
from planner.base.errors import OptionError


def test_no_beta_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="at least one beta"):
        bench_tables(tmp_path, betas=())
