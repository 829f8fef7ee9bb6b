"""How far a joint's motion moves a point."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.attack.reach import attack_reach
from planner.base.progress import QUIET
from planner.kinematics.reach import Reach


def test_a_reach_that_is_too_short_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    honest = Reach.motion
    monkeypatch.setattr(Reach, "motion", lambda self, delta: 0.98 * honest(self, delta))
    moved = attack_reach("planar_2r", 240, np.random.default_rng(0), QUIET)
    assert moved is not None
    assert moved.share > 1.0
    assert moved.over > 1e-6
