"""The same commands give the same answers as when the golden file was written."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from planner.base.versions import versions
from tests.golden import FILE, REQUESTS, SWEPT, answer, intervals

KEPT = json.loads(FILE.read_text())
OTHERS = sorted(name for name, version in versions().items() if name != "python" and KEPT["versions"][name] != version)
CPU = Path("/proc/cpuinfo")
same_bits = pytest.mark.skipif(
    bool(OTHERS) or not CPU.exists() or " fma " not in CPU.read_text(),
    reason=f"written with other versions ({', '.join(OTHERS) or 'none'}), or this is no x86-64 processor with FMA",
)


@same_bits
@pytest.mark.parametrize("name", REQUESTS)
def test_roadmap_and_path_are_those_that_were_kept(name: str) -> None:
    assert answer(REQUESTS[name]) == KEPT["plans"][name]


@same_bits
def test_the_intervals_of_beta_are_those_that_were_kept() -> None:
    assert intervals(SWEPT) == [pytest.approx(row, rel=1e-9) for row in KEPT["sweep"]]
