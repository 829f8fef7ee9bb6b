"""What is proven of a trajectory."""

from __future__ import annotations

import pytest

from planner.motion.report import report_record
from tests.motion.test_check import report_of


def test_excess_is_exact() -> None:
    """From rest to rest over d in T a cubic accelerates by 6 d / T² at its ends and runs at 1.5 d / T in the middle."""
    report = report_of([0.0, 0.4], [[-0.6, 0.0], [-0.3, 0.0]], [[0.0, 0.0], [0.0, 0.0]])
    assert report.proof is not None
    excess = report.proof.excesses[0]
    assert (excess.kind, excess.joint, excess.limit) == ("acceleration", "joint_1", 5.0)
    assert excess.value == pytest.approx(6 * 0.3 / 0.4**2)
    assert report_record(report)["shares"]["velocity"] == pytest.approx(1.5 * 0.3 / 0.4 / 2.0)
