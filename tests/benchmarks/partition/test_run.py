"""``benchmarks partition``: the same x from every method, and rows that are kept."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.partition import run as module
from benchmarks.partition.case import HERE, WHOLE
from benchmarks.partition.run import bench_partition
from planner.base.errors import OptionError


def test_every_method_has_a_row_with_the_same_x(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = bench_partition(tmp_path, arcs=(3000,))
    of = {row.method: row for row in found.rows}
    assert of[HERE].x_sha256 == of[WHOLE].x_sha256
    assert of[WHOLE].settled
    assert (of[HERE].told or 0) > (of[HERE].boundary or 0) > 0
    assert "one process" in found.report
    monkeypatch.setattr(module, "_measure", lambda *_, **__: [])  # nothing is measured again
    assert bench_partition(tmp_path, arcs=(3000,)).rows == found.rows


@pytest.mark.parametrize("bad", [{"arcs": (5,)}, {"blocks": 1}, {"steps": 0}, {"seed": -1}])
def test_numbers_that_make_no_sense_are_refused(bad: dict, tmp_path: Path) -> None:
    with pytest.raises(OptionError):
        bench_partition(tmp_path, **bad)
