"""The same commands give the same answers as when the golden file was written."""

import json
from pathlib import Path

import pytest

from planner.base.resources import versions
from tests.golden import CASES, FILE

KEPT = json.loads(FILE.read_text())
OTHERS = sorted(name for name, version in versions().items() if name != "python" and KEPT["versions"][name] != version)
CPU = Path("/proc/cpuinfo")


@pytest.mark.skipif(
    bool(OTHERS) or not CPU.exists() or " fma " not in CPU.read_text(),
    reason=f"written with other versions ({', '.join(OTHERS) or 'none'}), or this is no x86-64 processor with FMA",
)
@pytest.mark.parametrize("name", CASES)
def test_the_answer_is_the_recorded_one(name: str) -> None:
    assert json.loads(json.dumps(CASES[name]())) == KEPT["cases"][name]
